//! A step with effects: from bend to bend of the command, from segment to segment, from event to event.

use super::{Actuator, Failure, Inputs, State, Workspace};
use crate::{
    effects::UNLIMITED,
    error::{Error, Result},
    motion::{Event, Forcing, Motion, Point, Power},
    operator::{Answer, FAR_ABOVE, Piece, Segment},
    parameters::Order,
    series::{Decay, REACH, RECIPROCAL, Series, TERMS, terms_needed},
    transition::{Ramp, Transition},
};

/// Share of a step below which two instants are one.
const INSTANT: f64 = 1e-14;

/// Share of the size of the positions in a segment below which a difference is rounding: some hundred roundings.
const ROUNDING: f64 = 1e-13;

/// A series whose last terms are below this share of its largest has converged.
const CONVERGED: f64 = 1e-15;

/// Segments are halved at most this often for a series to converge; beyond, the motion runs away.
const HALVINGS: u32 = 40;

/// Events in a row without progress after which a segment is followed without looking for more.
const STALLED: u32 = 20;

/// What acts from one instant on.
struct Acting {
    /// Command behind its effects, and for how long that holds.
    command: Piece,
    load: Ramp,
    failure: Failure,
    /// Since the start [s].
    time: f64,
}

/// Segments that a step may take beyond those that its length asks for, and per such segment: far more than there are events in
/// any motion. A host must not be kept waiting for ever.
const PATIENCE: f64 = 1e4;

/// A step that is longer than this, in time constants of the fastest pole that series follow, would keep a host waiting for hours.
const LONGEST_STEP: f64 = 1e9;

/// Everything that moves during one segment. It is filled in place: series are large to move about.
#[derive(Debug, Clone)]
pub(super) struct Course {
    segment: Segment,
    pole: Series,
    motion: Motion,
    event: Option<(f64, Event)>,
    /// What each stage behind the drive makes of what it gets.
    answers: Vec<Answer>,
}

impl Default for Course {
    fn default() -> Self {
        let segment = Segment { length: 0.0, fastest: 0.0, terms: 0, tolerance: 0.0 };
        Self { segment, pole: Series::polynomial(&[0.0]), motion: Motion::default(), event: None, answers: Vec::new() }
    }
}

impl Actuator {
    /// Moves the state through the step.
    pub(super) fn follow(
        &self,
        state: &mut State,
        workspace: &mut Workspace,
        inputs: Inputs,
        duration: f64,
    ) -> Result<()> {
        let start = state.time;
        // Later than one rounding of the time.
        let instant = (INSTANT * duration).max(4.0 * f64::EPSILON * start.abs());
        let Inputs { command, load, failure } = inputs;
        let now = |done: f64| Piece { value: command.at(done), slope: command.slope, length: duration - done, instant };
        self.command.record(&mut state.history, start, now(0.0));
        let (mut done, mut stalled) = (0.0, 0);
        if duration * self.fastest > LONGEST_STEP {
            let allowed = format!("at most {:.3e} s where effects act", LONGEST_STEP / self.fastest);
            return Err(Error::new("communicationStepSize", format!("{duration:e} s"), allowed));
        }
        let mut patience = PATIENCE * (1.0 + duration * self.fastest);
        while done < duration {
            patience -= 1.0;
            if patience < 0.0 {
                let found = format!("events without end at {} s, {} deg", start + done, state.position);
                return Err(Error::new("motion in this step", found, "a finite number of events"));
            }
            let (time, rest) = (start + done, duration - done);
            let mut command =
                self.command.pieces(&state.history, &state.memory, time, now(done), &mut workspace.pieces);
            command.length = command.length.clamp(instant.min(rest), rest);
            let load = Ramp { value: load.at(done), slope: load.slope };
            if self.is_linear_behind_command && load.slope == 0.0 && failure == Failure::None {
                self.glide(state, workspace, command, self.terms.bias + load.value, duration);
                done = if command.length == rest { duration } else { done + command.length };
                continue;
            }
            let Workspace { pieces, course, .. } = &mut *workspace;
            self.course(state, &Acting { command, load, failure, time }, course)?;
            let (tau, event) = if stalled < STALLED { course.end() } else { (1.0, None) };
            self.advance(state, course, tau, event);
            let elapsed = tau * course.segment.length;
            self.command.advance(&mut state.memory, pieces, elapsed);
            stalled = if elapsed > instant { 0 } else { stalled + 1 };
            // The last segment ends where the step does, whatever the sum of its parts rounds to.
            done = if tau == 1.0 && course.segment.length == rest { duration } else { done + elapsed };
        }
        state.time = start + duration;
        Ok(())
    }

    /// Through a straight piece of a step, under a steady load.
    fn glide(&self, state: &mut State, workspace: &mut Workspace, piece: Piece, load: f64, step: f64) {
        let command = Ramp { value: piece.value, slope: piece.slope };
        if piece.length == step {
            state.glide(workspace.transition(self, step), command, load);
        } else {
            // No other piece is as long to the last bit.
            state.glide(&Transition::new(self.base, self.order, piece.length), command, load);
        }
        self.command.advance(&mut state.memory, &workspace.pieces, piece.length);
    }

    /// The next segment, of at most the length of the command's piece.
    fn course(&self, state: &State, acting: &Acting, course: &mut Course) -> Result<()> {
        let fastest = self.fastest.max(self.terms.pole(state.position));
        // As many equal segments as it takes.
        let whole = acting.command.length;
        let mut length = whole / (whole * fastest / REACH).ceil().max(1.0);
        let halvings = if self.terms.runs_away(state.position) { 0 } else { HALVINGS };
        for _ in 0..halvings {
            self.attempt(state, acting, length, fastest, course);
            if self.terms.cubic == 0.0 || course.motion.truncation() < CONVERGED {
                return Ok(());
            }
            length *= 0.5;
        }
        let found = format!("a surface that runs away from {:.3e} deg", state.position);
        Err(Error::new("motion in this step", found, "a stable actuator")
            .remedy("a negative amplitude_gain.cubic has no equilibrium at large commands"))
    }

    fn attempt(&self, state: &State, acting: &Acting, length: f64, fastest: f64, course: &mut Course) {
        let Acting { command, load, failure, time } = acting;
        let Course { segment, pole, motion, event, answers } = course;
        let terms = &self.terms;
        // Products of series need all terms.
        let count = if terms.cubic == 0.0 { terms_needed(fastest * length) } else { TERMS };
        *pole = self.pole(state.pole, self.command.demand(*command, *time, length), length, count);
        let stop;
        let (target, power) = match failure {
            Failure::None => (&*pole, Power::On),
            Failure::Passive => (&*pole, Power::Off),
            Failure::Stuck => (&*pole, Power::Stuck),
            Failure::HardoverPositive | Failure::HardoverNegative => {
                let positive = *failure == Failure::HardoverPositive;
                let limit = if positive { terms.max.min(UNLIMITED) } else { terms.min.max(-UNLIMITED) };
                stop = Series::polynomial(&[limit]);
                (&stop, Power::On)
            }
        };
        let forcing = Forcing { target, load: [load.value, load.slope * length], power };
        let from = terms.inside_limits(Point { position: state.position, rate: state.rate });
        let (low, high) = target.bounds();
        let size = from.position.abs() + (from.rate * length).abs() + low.abs().max(high.abs()) + load.value.abs();
        *segment = Segment { length, fastest: self.fastest, terms: count, tolerance: ROUNDING * size };
        *event = terms.motion(from, &forcing, *segment, motion);
        answers.clear();
        for stage in &self.stages {
            let input = answers.last().map_or(&motion.position, |answer| &answer.output);
            answers.push(stage.operator.answer(&stage.parameters, &state.memory[stage.memory..], input, *segment));
        }
    }

    /// ẋ = p (demand - x), or x = demand.
    fn pole(&self, now: f64, demand: [f64; 3], length: f64, count: usize) -> Series {
        let mut series = Series::polynomial(&demand);
        if self.order == Order::Second {
            return series;
        }
        let k = self.base.p() * length;
        if self.base.p() > FAR_ABOVE * self.fastest {
            // Settled: x = demand - demand' / k + demand'' / k²; and the decay of where it is from there.
            let [q0, q1, q2] = demand;
            series.terms[1] = q1 - 2.0 * q2 / k;
            series.terms[0] = q0 - series.terms[1] / k;
            series.decays[0] = Decay { amplitude: now - series.terms[0], exponent: k };
            return series;
        }
        let mut terms = [0.0; TERMS];
        terms[0] = now;
        for n in 0..count - 1 {
            terms[n + 1] = k * RECIPROCAL[n + 1] * (series.terms[n] - terms[n]);
        }
        Series { terms, length: count, ..series }
    }

    fn advance(&self, state: &mut State, course: &Course, tau: f64, event: Option<Event>) {
        let Course { segment, pole, motion, answers, .. } = course;
        state.pole = pole.at(tau);
        let point = motion.at(tau, event, segment.length);
        (state.position, state.rate) = (point.position, point.rate);
        state.saturated = motion.saturated;
        let mut input = &motion.position;
        for (stage, Answer { output, .. }) in self.stages.iter().zip(answers) {
            let memory = &mut state.memory[stage.memory..];
            stage.operator.advance(&stage.parameters, memory, input, output, *segment, tau);
            input = output;
        }
    }

    /// Slopes of position, deflection [deg/s] and rate [deg/s²] under these inputs.
    ///
    /// # Errors
    /// A motion that runs away.
    pub fn slopes(&self, state: &State, inputs: Inputs) -> Result<[f64; 3]> {
        let Inputs { command, load, failure } = inputs;
        let length = 0.1 * REACH / self.fastest;
        let instant = INSTANT * length;
        let now = Piece { value: command.value, slope: command.slope, length, instant };
        let mut history = state.history.clone();
        self.command.record(&mut history, state.time, now);
        let command = self.command.pieces(&history, &state.memory, state.time, now, &mut Vec::new());
        let acting = Acting { command: Piece { length, ..command }, load, failure, time: state.time };
        let mut course = Course::default();
        self.course(state, &acting, &mut course)?;
        let Course { segment, motion, answers, .. } = course;
        let rate = motion.position.derivative().scaled(1.0 / segment.length);
        let now = motion.rate_at_start(state.rate);
        let (mut deflection, mut position) = (now, now);
        for (stage, answer) in self.stages.iter().zip(&answers) {
            position = answer.output.slope_at_start() / segment.length;
            if !stage.is_sensor {
                deflection = position;
            }
        }
        position += self.readings.iter().map(|reading| (reading.slope)(&reading.parameters, state.time)).sum::<f64>();
        Ok([position, deflection, rate.slope_at_start() / segment.length])
    }
}

impl Course {
    /// The first instant at which something ceases to hold, and what the drive's part in it is; else the end.
    fn end(&self) -> (f64, Option<Event>) {
        let stages = self.answers.iter().filter_map(|answer| answer.until).reduce(f64::min);
        match (self.event, stages) {
            (Some((tau, event)), other) if other.is_none_or(|other| tau <= other) => (tau, Some(event)),
            (_, Some(other)) => (other, None),
            _ => (1.0, None),
        }
    }
}
