//! Why an explanation does not lead, on unseen records: compared with the base alone, the linear model, and the other effects.

use super::{
    hypothesis::family,
    unseen::{Judged, LEAST_BOOTSTRAP, NEARLY_NOTHING, bootstrap, excess, excesses},
    wide::implausible,
};
use crate::digits::with_unit;
use actuator_fmu::{effects::find, parameters::PositionUnit};

/// s, at most; and where the nonlinear part is explained whole (see `WHOLE_SHARE`), beside a base of another structure that leaves its own error.
const GREATEST_REMAINING_SHARE: f64 = 0.65;
const GREATEST_REMAINING_SHARE_OF_WHOLE: f64 = 0.8;
/// Difference in s, and in n, below which explanations are tied.
const LEAST_FAMILY_MARGIN: f64 = 0.10;
/// Share of the changing records on which the residual must decrease, two of three, and increase on any other, at most, as a share of the total
/// decrease.
const LEAST_FALLING_SHARE: f64 = 0.66;
const GREATEST_RISE: f64 = 0.1;
/// Change of a record below which there is none, as a share of the total decrease.
const NEGLIGIBLE_CHANGE: f64 = 0.02;
/// Rms of an effect over that of the linear model, at most.
pub const GREATEST_OVER_RIVAL: f64 = 0.9;
/// Or n, at most.
const GREATEST_NONLINEAR_SHARE: f64 = 0.5;
/// n of an effect over that of the free base, at most.
const GREATEST_SHARE_OF_BASE: f64 = 0.9;
/// n below which an effect explains the nonlinear part whole.
const WHOLE_SHARE: f64 = 0.25;
/// n of every other family over that of an effect that explains the nonlinear part alone, at least.
const NONLINEAR_RATIO: f64 = 3.0;
/// E_lin over E_free, at least, for an effect to lead by the nonlinear part alone.
const LEAST_NONLINEAR_PART: f64 = 0.05;
/// Largest over smallest strength among the records that show the effect: friction under a changing load varies by three.
pub const GREATEST_STRENGTH_RATIO: f64 = 4.0;
/// The same among all records, for an effect that explains the nonlinear part alone and little of E_free.
const GREATEST_RATIO_OF_SMALL_PART: f64 = 3.0;
/// g above which hysteresis is no small part of the difference.
const LEAST_PART_OF_DIFFERENCE: f64 = 0.25;
/// Excess explained by hysteresis with a smaller g over the sum of squares of the positions, at least. Every mechanical actuator has some friction
/// and play, also the one to which the given model was fitted: where it is small and a free base explains most of the difference, that is mainly
/// linear.
const LEAST_HYSTERESIS_OF_MOTION: f64 = 0.065 * 0.065;
/// g about the levels, at least, unless s is below `NEARLY_NOTHING` or n below the second number: beside a free base that explains all the rest, a
/// smaller part is some error of that base's structure.
const LEAST_SMALL_PART: f64 = 0.06;
const LEFT_BY_SMALL_PART: f64 = 0.15;
/// Effects as which friction and play of any rig appear, wherever they act.
pub const HYSTERESIS: [&str; 4] = ["command_backlash", "dead_zone", "coulomb_friction", "backlash"];
const PLAY: [&str; 2] = ["command_backlash", "backlash"];
const FRICTION: [&str; 2] = ["dead_zone", "coulomb_friction"];
/// s of friction over that of play, at least, where it is play. On 210 healthy repeats of the suite's rigs, play that explained four fifths or more
/// left as much as friction, or 0.9 of it, once 0.7; where play had been added and explained nine tenths, it left 0.3 to 0.8 of it.
const LEFT_BY_FRICTION_OVER_PLAY: f64 = 1.25;
/// Excess of hysteresis in the given model, its base held, over E_given, both about the levels, at most, for it to be what the model lacks. A free
/// base may explain most of it: play and friction have a lag.
const GREATEST_LEFT_IN_GIVEN: f64 = 1.0 / 3.0;
/// The same where g exceeds the second number.
const GREATEST_LEFT_BESIDE_PART: f64 = 0.5;
const LEAST_PART_BESIDE_BASE: f64 = 0.05;
/// g, at least, of an effect that leads because it explains nearly everything.
const LEAST_PART_OF_NEARLY_ALL: f64 = 0.02;
/// n below which an effect explains all of the nonlinear part.
const LEFT_OF_ALL_NONLINEAR: f64 = 0.05;
/// A record shows an effect that explains this share of its excess; beside a linear model it must have this share of E_lin.
const SHOWN_SHARE: f64 = 0.15;

/// What an explanation is compared with.
pub struct Rivals<'a> {
    /// Mean square of the free base alone on each unseen record, and sums of squares of its residual in blocks.
    pub base_left: &'a [f64],
    pub base_blocks: &'a [f64],
    /// Mean square of the linear model on each unseen record.
    pub linear_left: &'a [f64],
    /// n of the base alone, which is linear: it explains no more than linear filters of its own position do.
    pub share_beside_base: Option<f64>,
    /// Samples of each record.
    pub counts: &'a [f64],
    /// Mean square of each record's noise.
    pub noise: &'a [f64],
    /// Excess of the given model, and that about the levels.
    pub given_excess: f64,
    pub given_excess_about_levels: f64,
    /// Sum of squares of the positions about their means.
    pub motion: f64,
}

impl Rivals<'_> {
    /// Why an explanation does not lead; none where it does.
    pub fn why_not(&self, place: usize, judged: &[Judged]) -> Option<String> {
        let own = &judged[place];
        let small_hysteresis = || self.may_be_of_any_rig(own, judged).then(|| self.small_hysteresis(own)).flatten();
        self.without_regard_to_given(place, judged).or_else(small_hysteresis)
    }

    /// Whether the only possible objection to an explanation is its excess in the given model.
    pub fn is_told_by_given(&self, place: usize, judged: &[Judged]) -> bool {
        self.may_be_of_any_rig(&judged[place], judged) && self.without_regard_to_given(place, judged).is_none()
    }

    fn without_regard_to_given(&self, place: usize, judged: &[Judged]) -> Option<String> {
        self.objection(place, judged).or_else(|| self.small_part(&judged[place]))
    }

    /// Whether an effect may be the friction or play that every mechanical actuator has.
    fn may_be_of_any_rig(&self, own: &Judged, judged: &[Judged]) -> bool {
        HYSTERESIS.contains(&own.effect) && !is_play_and_no_friction(own, judged)
    }

    /// The objection to an effect as such, whatever its size.
    fn objection(&self, place: usize, judged: &[Judged]) -> Option<String> {
        let own = &judged[place];
        if self.is_told_beside_linear(own, judged) {
            if self.takes_all_nonlinear(own) {
                // One common strength suffices: strengths of single records beside an inaccurate base contain its error as well.
                return None;
            }
            let shows = self.shows_beside_linear();
            return if self.takes_a_large_part(own) {
                varying_strength((own.effect, own.fit.model.unit()), &own.of_records, &shows, GREATEST_STRENGTH_RATIO)
            } else {
                varying_strength(
                    (own.effect, own.fit.model.unit()),
                    &own.of_records,
                    &vec![true; shows.len()],
                    GREATEST_RATIO_OF_SMALL_PART,
                )
            };
        }
        let is_whole = own.nonlinear_share.is_some_and(|share| share < WHOLE_SHARE);
        if own.remaining_share > if is_whole { GREATEST_REMAINING_SHARE_OF_WHOLE } else { GREATEST_REMAINING_SHARE } {
            return Some(format!("on unseen records {:.0} % of the excess remains", 100.0 * own.remaining_share));
        }
        if let Some(reason) = implausible(&own.fit) {
            return Some(reason);
        }
        let pairs = self.base_left.iter().zip(&own.left).zip(self.counts);
        let falls: Vec<f64> = pairs.map(|((base, own), count)| count * (base - own)).collect();
        let fall: f64 = falls.iter().filter(|fall| **fall > 0.0).sum();
        let rising = falls.iter().find(|change| -**change > GREATEST_RISE * fall);
        // The residual of a record that does not show the effect neither decreases nor increases.
        let shown: Vec<f64> = falls.iter().copied().filter(|change| change.abs() > NEGLIGIBLE_CHANGE * fall).collect();
        #[allow(clippy::cast_precision_loss)] // counts of records
        let falling = shown.iter().filter(|fall| **fall > 0.0).count() as f64 / shown.len().max(1) as f64;
        if rising.is_some() || falling < LEAST_FALLING_SHARE {
            return Some("the residual increases on some unseen records".to_owned());
        }
        if !own.beats_linear {
            return Some(
                "a linear system of another structure explains unseen records equally well: the actuator differs from the base in structure"
                    .to_owned(),
            );
        }
        let others = || judged.iter().filter(|other| family(other.effect) != family(own.effect));
        if let Some(other) = others().find(|other| comes_as_near(other, own)) {
            return Some(format!("{} of another family explains unseen records equally well", other.effect));
        }
        let other = others().next();
        // A limit acts in few parts of the records: it suffices that these are explained whole on unseen records.
        let sound = |rival: &[f64]| bootstrap(rival, &own.blocks);
        if !is_whole && sound(self.base_blocks).min(other.map_or(1.0, |other| sound(&other.blocks))) < LEAST_BOOTSTRAP {
            return Some("its gain depends on few parts of the records".to_owned());
        }
        varying_strength((own.effect, own.fit.model.unit()), &own.of_records, &self.shows(own), GREATEST_STRENGTH_RATIO)
    }

    /// Whether an effect explains the nonlinear part, and no other family does: a base of another structure leaves its own error beside any effect.
    fn is_told_beside_linear(&self, own: &Judged, judged: &[Judged]) -> bool {
        let excess = |left: &[f64]| excess(left, self.noise, self.counts);
        let nonlinear_part = excess(self.linear_left) / excess(self.base_left);
        let mut others = judged.iter().filter(|other| family(other.effect) != family(own.effect));
        own.nonlinear_share.is_some_and(|share| {
            let least = (NONLINEAR_RATIO * share).max(share + LEAST_FAMILY_MARGIN);
            let is_behind = |other: &Judged| other.nonlinear_share.is_some_and(|other| other > least);
            nonlinear_part > LEAST_NONLINEAR_PART
                && self.takes_more_than_base(own)
                && share < WHOLE_SHARE
                && others.all(is_behind)
                && implausible(&own.fit).is_none()
                && self.is_of_one_strength(own)
        })
    }

    /// Whether it explains nearly all that the base and the linear model leave, and some part of the difference.
    pub fn takes_nearly_all(&self, own: &Judged) -> bool {
        own.leaves_nearly_nothing() && self.taken(own) > LEAST_PART_OF_NEARLY_ALL * self.given_excess
    }

    /// Whether it explains all of the nonlinear part, and some part of the difference.
    fn takes_all_nonlinear(&self, own: &Judged) -> bool {
        own.nonlinear_share.is_some_and(|share| share < LEFT_OF_ALL_NONLINEAR)
            && self.taken(own) > LEAST_PART_OF_NEARLY_ALL * self.given_excess
    }

    /// Whether it explains a part of the difference that is not small; about the levels where it explains the nonlinear part whole.
    fn takes_part(&self, own: &Judged) -> bool {
        let is_whole = own.nonlinear_share.is_some_and(|share| share < WHOLE_SHARE);
        let difference = if is_whole { self.given_excess_about_levels } else { self.given_excess };
        self.taken(own) > LEAST_PART_OF_DIFFERENCE * difference
    }

    /// Excess that it explains beyond the free base, E_free - E.
    fn taken(&self, own: &Judged) -> f64 {
        let excess = |left: &[f64]| excess(left, self.noise, self.counts);
        excess(self.base_left) - excess(&own.left)
    }

    /// Why it explains too little of the difference beyond the free base; none otherwise.
    pub fn small_part(&self, own: &Judged) -> Option<String> {
        let part = self.taken(own) / self.given_excess_about_levels;
        let is_small = part < LEAST_SMALL_PART
            && own.remaining_share > NEARLY_NOTHING
            && own.nonlinear_share.is_none_or(|share| share > LEFT_BY_SMALL_PART);
        is_small.then(|| self.words_of_part(own))
    }

    /// The parts of the difference that the free base and an effect beside it explain, in words.
    fn words_of_part(&self, own: &Judged) -> String {
        let of_base = self.given_excess - excess(self.base_left, self.noise, self.counts);
        let [of_base, taken] =
            [of_base, self.taken(own)].map(|part| 100.0 * (part / self.given_excess).clamp(0.0, 1.0));
        format!(
            "a free base alone explains {of_base:.0} % of the variance of the difference, the effect {taken:.0} % more"
        )
    }

    /// Why it is hysteresis that explains little of the difference beyond the free base and is small relative to the motion; none otherwise.
    pub fn small_hysteresis(&self, own: &Judged) -> Option<String> {
        let taken = self.taken(own);
        let takes_part = taken > LEAST_PART_BESIDE_BASE * self.given_excess;
        let most = if takes_part { GREATEST_LEFT_BESIDE_PART } else { GREATEST_LEFT_IN_GIVEN };
        let is_small = own.left_in_given.is_none_or(|left| left > most)
            && !self.takes_nearly_all(own)
            && !self.takes_all_nonlinear(own)
            && !self.takes_part(own)
            && taken < LEAST_HYSTERESIS_OF_MOTION * self.motion;
        is_small.then(|| format!("{}: every actuator has some friction and play", self.words_of_part(own)))
    }

    /// Whether it explains as much of E_free as a lead must, beside the base alone or with a linear model beside both.
    fn takes_a_large_part(&self, own: &Judged) -> bool {
        let excess = |left: &[f64]| excess(left, self.noise, self.counts);
        let beside_linear = excess(self.linear_left) - excess(&own.beside_linear);
        (1.0 - own.remaining_share).max(beside_linear / excess(self.base_left)) > 1.0 - GREATEST_REMAINING_SHARE
    }

    /// Whether the strength that all records share explains every record with a large part of E_lin.
    fn is_of_one_strength(&self, own: &Judged) -> bool {
        let excesses = |left| excesses(left, self.noise, self.counts);
        let mut pairs = excesses(&own.beside_linear).zip(excesses(self.linear_left)).zip(self.shows_beside_linear());
        pairs.all(|((beside, linear), shows)| !shows || beside < GREATEST_NONLINEAR_SHARE * linear)
    }

    /// Whether each record has a large part of E_lin.
    fn shows_beside_linear(&self) -> Vec<bool> {
        let left: Vec<f64> = excesses(self.linear_left, self.noise, self.counts).collect();
        let all: f64 = left.iter().sum();
        left.iter().map(|left| *left >= SHOWN_SHARE * all).collect()
    }

    /// Whether an effect explains much of the excess of each record.
    fn shows(&self, own: &Judged) -> Vec<bool> {
        let records = self.base_left.iter().zip(&own.left).zip(self.noise);
        let shows = |((base, own), noise): ((&f64, &f64), &f64)| {
            (base - own) / (base - noise).max(f64::MIN_POSITIVE) > SHOWN_SHARE
        };
        records.map(shows).collect()
    }

    /// Whether, with a linear model beside both, its residual is smaller than that of the base, which is linear.
    fn takes_more_than_base(&self, own: &Judged) -> bool {
        let shares = own.nonlinear_share.zip(self.share_beside_base);
        shares.is_none_or(|(own, base)| own < GREATEST_SHARE_OF_BASE * base)
    }

    /// See [`Judged::beats_linear`].
    pub fn beats_linear(&self, own: &Judged) -> bool {
        let total = |left: &[f64]| -> f64 { left.iter().zip(self.counts).map(|(left, count)| count * left).sum() };
        let is_less = (total(&own.left) / total(self.linear_left)).sqrt() <= GREATEST_OVER_RIVAL;
        self.takes_more_than_base(own)
            && (is_less || own.nonlinear_share.is_some_and(|share| share < GREATEST_NONLINEAR_SHARE))
    }
}

/// Whether it is play that friction, which every mechanical actuator has, does not imitate: it explains nearly all that a free base leaves, and
/// friction and a dead zone leave a quarter more.
pub fn is_play_and_no_friction(own: &Judged, judged: &[Judged]) -> bool {
    let mut friction = judged.iter().filter(|other| FRICTION.contains(&other.effect));
    PLAY.contains(&own.effect)
        && own.leaves_nearly_nothing()
        && friction.all(|other| other.remaining_share > LEFT_BY_FRICTION_OVER_PLAY * own.remaining_share.max(0.0))
}

/// Whether another explanation is tied with one, in s and in n; values below 0 count as 0.
pub fn comes_as_near(other: &Judged, own: &Judged) -> bool {
    let is_near = |other: f64, own: f64| other.max(0.0) < own.max(0.0) + LEAST_FAMILY_MARGIN;
    let beside = other.nonlinear_share.zip(own.nonlinear_share);
    is_near(other.remaining_share, own.remaining_share) && beside.is_none_or(|(other, own)| is_near(other, own))
}

/// How the strength differs between the records that show the effect, where it differs too much.
pub fn varying_strength(
    (effect, position): (&str, PositionUnit),
    of_records: &[Vec<f64>],
    shows: &[bool],
    greatest_ratio: f64,
) -> Option<String> {
    let effect = find(effect)?;
    // A record that does not reach a side of a limit does not determine it.
    if effect.family.name() == "limit" {
        return None;
    }
    let deciding = effect.parameters.iter().zip(of_records).filter(|(parameter, _)| parameter.decides);
    for (parameter, values) in deciding {
        let shown = values.iter().zip(shows).filter(|(value, shows)| **shows && value.is_finite());
        let (least, greatest) = shown.fold((f64::INFINITY, 0.0), |(low, high): (f64, f64), (value, _)| {
            (low.min(value.abs()), high.max(value.abs()))
        });
        if greatest > greatest_ratio * least {
            let unit = position.derived(parameter.unit);
            let [least, greatest] = [least, greatest].map(|value| with_unit(value, 3, unit));
            return Some(format!("{} {least} in one record and {greatest} in another", parameter.name));
        }
    }
    None
}
