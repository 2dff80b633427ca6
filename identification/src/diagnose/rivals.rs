//! Why an explanation is no lead, on records that it was not fitted to: against the base alone, the flexible linear model, and the other effects.

use super::{
    hypothesis::family,
    unseen::{Judged, LEAST_BOOTSTRAP, bootstrap, excess, excesses},
    wide::implausible,
};
use crate::digits::with_unit;
use actuator_fmu::effects::find;

/// Share of the excess that a lead may leave; and one that explains whole what a linear model leaves, beside a base of another structure that
/// leaves its own error.
const GREATEST_LEFT_SHARE: f64 = 0.65;
const GREATEST_LEFT_SHARE_OF_WHOLE: f64 = 0.8;
/// The share that a lead may leave, for the best of another family beyond the lead's own.
const LEAST_FAMILY_MARGIN: f64 = 0.10;
/// Share of the records on which a lead must gain, two of three, and the rise on any other, as a share of the fall of all.
const LEAST_FALLING_SHARE: f64 = 0.66;
const GREATEST_RISE: f64 = 0.1;
/// A change of a record below this share of the fall of all is none.
const NEGLIGIBLE_CHANGE: f64 = 0.02;
/// Root mean square over that of the linear rival.
pub const GREATEST_OVER_RIVAL: f64 = 0.9;
/// Or, with a flexible linear model beside it, share of the excess over the noise that such a model leaves by itself.
const GREATEST_NONLINEAR_SHARE: f64 = 0.5;
/// The same share, as a share of what the base leaves with such a model beside it.
const GREATEST_SHARE_OF_BASE: f64 = 0.9;
/// The same share below which what a linear model leaves is explained whole.
const WHOLE_SHARE: f64 = 0.25;
/// How many times as much every other family leaves of it.
const NONLINEAR_RATIO: f64 = 3.0;
/// Of the base's excess, what a linear model leaves at least for an effect to be told by that alone.
const LEAST_NONLINEAR_PART: f64 = 0.05;
/// Largest over smallest strength between records that show the effect: friction under a changing load varies by three.
const GREATEST_STRENGTH_RATIO: f64 = 4.0;
/// The same among all records, of an effect that is told beside a linear model alone and takes little of the base's excess.
const GREATEST_RATIO_OF_SMALL_PART: f64 = 3.0;
/// Of the excess that the given model leaves, what an effect takes beyond the base where it is no small part of the difference.
const LEAST_PART_OF_DIFFERENCE: f64 = 0.25;
/// Hysteresis that takes less must take this part of the variance of the position to lead. Every mechanical actuator has some, also the one to which
/// the given model was fitted: where it is small, and a base of its own takes most of the difference, that is linear first of all.
const LEAST_HYSTERESIS_OF_MOTION: f64 = 0.065 * 0.065;
/// Shares below which an effect takes nearly all that the base, and a flexible linear model, leave.
const NEARLY_NOTHING: f64 = 0.1;
/// Of the excess that the given model leaves about the levels of the records, what an effect takes at least beyond the base, but for one that leaves next
/// to nothing of what the base does (see above), or no more than this share beside a linear model. Beside a base that takes all the rest, what takes less is
/// some error of that base's structure.
const LEAST_SMALL_PART: f64 = 0.06;
const LEFT_BY_SMALL_PART: f64 = 0.15;
/// Effects in which friction and play of any rig show, wherever they act.
pub const HYSTERESIS: [&str; 4] = ["command_backlash", "dead_zone", "coulomb_friction", "backlash"];
const PLAY: [&str; 2] = ["command_backlash", "backlash"];
const FRICTION: [&str; 2] = ["dead_zone", "coulomb_friction"];
/// What friction leaves of the base's excess over what play does, where it is play. On 210 healthy repeats of the suite's rigs play that took four fifths or more left
/// as much as friction, or 0.9 of it, but once 0.7; where play had been added, and took nine tenths, 0.3 to 0.8.
const LEFT_BY_FRICTION_OVER_PLAY: f64 = 1.25;
/// Of the excess that the given model leaves, what hysteresis leaves in that model, its base as it is, where it is what the model lacks. A base of its own
/// may take most of it: play and friction are late.
const GREATEST_LEFT_IN_GIVEN: f64 = 1.0 / 3.0;
/// The same where it takes this part of that excess beyond what a base of its own does.
const GREATEST_LEFT_BESIDE_PART: f64 = 0.5;
const LEAST_PART_BESIDE_BASE: f64 = 0.05;
/// Of the excess that the given model leaves, what an effect takes at least to lead because it leaves nearly nothing.
const LEAST_PART_OF_NEARLY_ALL: f64 = 0.02;
/// With a flexible linear model beside it, what of the excess of such a model an effect leaves that takes all that no linear system does.
const LEFT_OF_ALL_NONLINEAR: f64 = 0.05;
/// A record shows an effect that takes this share of its excess; beside a linear model, one with this share of the excess of all.
const SHOWN_SHARE: f64 = 0.15;

/// What an explanation is judged against.
pub struct Rivals<'a> {
    /// Mean square that the base alone leaves on each unseen record, and sums of squares of blocks.
    pub base_left: &'a [f64],
    pub base_blocks: &'a [f64],
    /// The same of the flexible linear model.
    pub linear_left: &'a [f64],
    /// As [`Judged::nonlinear_share`], of the base alone: it is linear, and takes no more than linear filters of its own position do.
    pub share_beside_base: Option<f64>,
    /// Samples of each record.
    pub counts: &'a [f64],
    /// Mean square of each record's noise.
    pub noise: &'a [f64],
    /// Excess over the noise that the given model leaves, and that about the levels of the records.
    pub given_excess: f64,
    pub given_excess_about_levels: f64,
    /// Sum of squares of the positions about their means.
    pub motion: f64,
}

impl Rivals<'_> {
    /// Why an explanation is no lead; none where it is one.
    pub fn why_not(&self, place: usize, judged: &[Judged]) -> Option<String> {
        let own = &judged[place];
        let small_hysteresis = || self.may_be_of_any_rig(own, judged).then(|| self.small_hysteresis(own)).flatten();
        self.without_regard_to_given(place, judged).or_else(small_hysteresis)
    }

    /// Whether all that may speak against an explanation is what it leaves in the given model.
    pub fn is_told_by_given(&self, place: usize, judged: &[Judged]) -> bool {
        self.may_be_of_any_rig(&judged[place], judged) && self.without_regard_to_given(place, judged).is_none()
    }

    fn without_regard_to_given(&self, place: usize, judged: &[Judged]) -> Option<String> {
        self.objection(place, judged).or_else(|| self.small_part(&judged[place]))
    }

    /// Whether an effect is friction or play as every mechanical actuator has.
    fn may_be_of_any_rig(&self, own: &Judged, judged: &[Judged]) -> bool {
        HYSTERESIS.contains(&own.effect) && !is_play_and_no_friction(own, judged)
    }

    /// What speaks against an effect as such, of whatever size.
    fn objection(&self, place: usize, judged: &[Judged]) -> Option<String> {
        let own = &judged[place];
        if self.is_told_beside_linear(own, judged) {
            if self.takes_all_nonlinear(own) {
                // One strength does: those of single records, beside a base that is off, tell its error as well.
                return None;
            }
            let shows = self.shows_beside_linear();
            return if self.takes_a_large_part(own) {
                varying_strength(own, &shows, GREATEST_STRENGTH_RATIO)
            } else {
                varying_strength(own, &vec![true; shows.len()], GREATEST_RATIO_OF_SMALL_PART)
            };
        }
        let is_whole = own.nonlinear_share.is_some_and(|share| share < WHOLE_SHARE);
        if own.left_share > if is_whole { GREATEST_LEFT_SHARE_OF_WHOLE } else { GREATEST_LEFT_SHARE } {
            return Some(format!("on unseen records {:.0} % of the excess remains", 100.0 * own.left_share));
        }
        if let Some(reason) = implausible(&own.fit) {
            return Some(reason);
        }
        let pairs = self.base_left.iter().zip(&own.left).zip(self.counts);
        let falls: Vec<f64> = pairs.map(|((base, own), count)| count * (base - own)).collect();
        let fall: f64 = falls.iter().filter(|fall| **fall > 0.0).sum();
        let rising = falls.iter().find(|change| -**change > GREATEST_RISE * fall);
        // A record that does not show the effect neither falls nor rises.
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
        // A limit acts in few parts: where these are explained whole on unseen records, they are enough.
        let sound = |rival: &[f64]| bootstrap(rival, &own.blocks);
        if !is_whole && sound(self.base_blocks).min(other.map_or(1.0, |other| sound(&other.blocks))) < LEAST_BOOTSTRAP {
            return Some("its gain depends on few parts of the records".to_owned());
        }
        varying_strength(own, &self.shows(own), GREATEST_STRENGTH_RATIO)
    }

    /// Whether an effect takes what no linear system explains, and no other family does: on a base of another structure, which leaves its own
    /// error beside any effect.
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

    /// Whether it takes nearly all that the base, and a flexible linear model, leave, and that is some part of the difference.
    pub fn takes_nearly_all(&self, own: &Judged) -> bool {
        let leaves_nearly_nothing =
            own.left_share < NEARLY_NOTHING && own.nonlinear_share.is_some_and(|share| share < NEARLY_NOTHING);
        leaves_nearly_nothing && self.taken(own) > LEAST_PART_OF_NEARLY_ALL * self.given_excess
    }

    /// Whether it takes all that no linear system does, and that is some part of the difference.
    fn takes_all_nonlinear(&self, own: &Judged) -> bool {
        own.nonlinear_share.is_some_and(|share| share < LEFT_OF_ALL_NONLINEAR)
            && self.taken(own) > LEAST_PART_OF_NEARLY_ALL * self.given_excess
    }

    /// Whether it takes a part of the difference that is not small; where it explains whole what a linear model leaves, of that about the levels of the records.
    fn takes_part(&self, own: &Judged) -> bool {
        let is_whole = own.nonlinear_share.is_some_and(|share| share < WHOLE_SHARE);
        let difference = if is_whole { self.given_excess_about_levels } else { self.given_excess };
        self.taken(own) > LEAST_PART_OF_DIFFERENCE * difference
    }

    /// Excess over the noise that it takes beyond the base.
    fn taken(&self, own: &Judged) -> f64 {
        let excess = |left: &[f64]| excess(left, self.noise, self.counts);
        excess(self.base_left) - excess(&own.left)
    }

    /// That it takes little of the difference beside what a base of its own takes.
    pub fn small_part(&self, own: &Judged) -> Option<String> {
        let part = self.taken(own) / self.given_excess_about_levels;
        let is_small = part < LEAST_SMALL_PART
            && own.left_share > NEARLY_NOTHING
            && own.nonlinear_share.is_none_or(|share| share > LEFT_BY_SMALL_PART);
        is_small.then(|| self.words_of_part(own))
    }

    /// What a base of its own takes, and what an effect beside it.
    fn words_of_part(&self, own: &Judged) -> String {
        let of_base = self.given_excess - excess(self.base_left, self.noise, self.counts);
        let [of_base, taken] =
            [of_base, self.taken(own)].map(|part| 100.0 * (part / self.given_excess).clamp(0.0, 1.0));
        format!(
            "a free base alone explains {of_base:.0} % of the variance of the difference, the effect {taken:.0} % more"
        )
    }

    /// That it is hysteresis which takes little of the difference beside what a base of its own takes and is small beside the motion.
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

    /// Whether it takes as much of the base's excess as a lead does, beside that base or with a flexible linear model beside both.
    fn takes_a_large_part(&self, own: &Judged) -> bool {
        let excess = |left: &[f64]| excess(left, self.noise, self.counts);
        let beside_linear = excess(self.linear_left) - excess(&own.beside_linear);
        (1.0 - own.left_share).max(beside_linear / excess(self.base_left)) > 1.0 - GREATEST_LEFT_SHARE
    }

    /// Whether every record in which a linear model leaves much is explained by the strength that all share.
    fn is_of_one_strength(&self, own: &Judged) -> bool {
        let excesses = |left| excesses(left, self.noise, self.counts);
        let mut pairs = excesses(&own.beside_linear).zip(excesses(self.linear_left)).zip(self.shows_beside_linear());
        pairs.all(|((beside, linear), shows)| !shows || beside < GREATEST_NONLINEAR_SHARE * linear)
    }

    /// Records in which a linear model leaves much.
    fn shows_beside_linear(&self) -> Vec<bool> {
        let left: Vec<f64> = excesses(self.linear_left, self.noise, self.counts).collect();
        let all: f64 = left.iter().sum();
        left.iter().map(|left| *left >= SHOWN_SHARE * all).collect()
    }

    /// Records of whose excess over the noise an effect takes much.
    fn shows(&self, own: &Judged) -> Vec<bool> {
        let records = self.base_left.iter().zip(&own.left).zip(self.noise);
        let shows = |((base, own), noise): ((&f64, &f64), &f64)| {
            (base - own) / (base - noise).max(f64::MIN_POSITIVE) > SHOWN_SHARE
        };
        records.map(shows).collect()
    }

    /// Whether, with a flexible linear model beside both, it leaves less than the base, which is linear.
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

/// Whether it is play that friction, which every mechanical actuator has, does not imitate: it takes nearly all that a base of its own leaves, and friction or a
/// dead zone leaves a quarter more.
pub fn is_play_and_no_friction(own: &Judged, judged: &[Judged]) -> bool {
    let is_nearly_all =
        own.left_share < NEARLY_NOTHING && own.nonlinear_share.is_some_and(|share| share < NEARLY_NOTHING);
    let mut friction = judged.iter().filter(|other| FRICTION.contains(&other.effect));
    PLAY.contains(&own.effect)
        && is_nearly_all
        && friction.all(|other| other.left_share > LEFT_BY_FRICTION_OVER_PLAY * own.left_share.max(0.0))
}

/// Whether another explanation comes as near as one: on its base, and with a flexible linear model beside both. What leaves less than the noise leaves
/// nothing.
pub fn comes_as_near(other: &Judged, own: &Judged) -> bool {
    let is_near = |other: f64, own: f64| other.max(0.0) < own.max(0.0) + LEAST_FAMILY_MARGIN;
    let beside = other.nonlinear_share.zip(own.nonlinear_share);
    is_near(other.left_share, own.left_share) && beside.is_none_or(|(other, own)| is_near(other, own))
}

/// Strengths that differ between the records that show the effect.
fn varying_strength(own: &Judged, shows: &[bool], greatest_ratio: f64) -> Option<String> {
    let effect = find(own.effect)?;
    // A side of a limit that a record does not reach says nothing.
    if effect.family.name() == "limit" {
        return None;
    }
    let deciding = effect.parameters.iter().zip(&own.of_records).filter(|(parameter, _)| parameter.decides);
    for (parameter, values) in deciding {
        let shown = values.iter().zip(shows).filter(|(value, shows)| **shows && value.is_finite());
        let (least, greatest) = shown.fold((f64::INFINITY, 0.0), |(low, high): (f64, f64), (value, _)| {
            (low.min(value.abs()), high.max(value.abs()))
        });
        if greatest > greatest_ratio * least {
            let unit = own.fit.model.unit().derived(parameter.unit);
            let [least, greatest] = [least, greatest].map(|value| with_unit(value, 3, unit));
            return Some(format!("{} {least} in one record and {greatest} in another", parameter.name));
        }
    }
    None
}
