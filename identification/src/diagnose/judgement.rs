//! All explanations of some records, judged on unseen records, and which of them lead.

use super::{
    given_effects::delay_s,
    hypothesis::family,
    plain_fit::PlainFit,
    predictable::{ADEQUATE_SHARE, Predictable},
    rivals::{GREATEST_OVER_RIVAL, comes_as_near},
    steady_rate::ACCELERATION_LIMIT,
    unseen::Judged,
};
use crate::sorting::sort_by_number;

/// Mean square of an effect beside its own free base over that of a delay beside the given base, at most, for the effect to lead instead.
const CLEARLY_LESS: f64 = 0.5;
/// g of an effect, at least, to lead instead of a delay beside the given base whose share left, d, is below the second number.
const SMALL_BESIDE_DELAY: f64 = 0.06;
const LEFT_BESIDE_SMALL: f64 = 0.15;
/// Delay of an effect's own base over that of the delay beside the given base, above which the effect needs the delay as well.
const MOST_OF_DELAY: f64 = 0.7;

/// Mean square of a rate limit over that of an acceleration limit, at most, for the former to lead where the latter limits the rate as well: a rate
/// limit is seen in the motion.
const AS_MUCH: f64 = 1.5;
const RATE_LIMIT: &str = "rate_limit";

/// All explanations of some records.
#[derive(Clone)]
pub struct Judgement {
    /// The free base without an effect.
    pub base: PlainFit,
    /// Its mean square on each unseen record.
    pub base_left: Vec<f64>,
    /// The same of the linear model.
    pub linear_left: Vec<f64>,
    /// The effects, best first.
    pub judged: Vec<Judged>,
    /// The part of the free base's residual that the motion predicts.
    pub base_predictable: Predictable,
    /// Whether the acceleration limit among them holds the motion at its steady rate.
    pub limits_rate: bool,
    /// Delay of the given model [s].
    pub given_delay_s: f64,
    /// A delay beside the given base.
    pub delay: Option<Judged>,
    /// A base near the given one that is as good as a delay that explains nearly everything, or that explains nearly everything itself.
    pub base_as_late: Option<PlainFit>,
}

impl Judgement {
    /// Whether what is missing is linear: the free base leaves noise, or the linear model explains unseen records as well as the best effect.
    pub fn is_linear(&self) -> bool {
        let total = |left: &[f64]| left.iter().sum::<f64>();
        let best = self.judged.first().map_or(f64::INFINITY, |best| total(&best.left));
        self.base_predictable.share < ADEQUATE_SHARE || (best / total(&self.linear_left)).sqrt() > GREATEST_OVER_RIVAL
    }

    /// The lead, with the tied members of its family; after it the other members of its family that lead themselves, tied ones first.
    pub fn leads(&self) -> Vec<(&Judged, Vec<String>)> {
        // An effect with a smaller residual that does not lead may be of its family. Within a family n decides, which is independent of the structure
        // of the base.
        let first = self.judged.iter().find(|judged| judged.why_not.is_none());
        let total = |judged: &Judged| judged.left.iter().sum::<f64>();
        let added_s = |judged: &Judged| delay_s(&judged.fit.model) - self.given_delay_s;
        if let Some(delay) = self.delay.as_ref().filter(|delay| delay.why_not.is_none())
            && first.is_none_or(|first| {
                total(first) > CLEARLY_LESS * total(delay)
                    || added_s(first) > MOST_OF_DELAY * added_s(delay)
                    || (first.part < SMALL_BESIDE_DELAY && delay.remaining_share < LEFT_BESIDE_SMALL)
            })
        {
            return vec![(delay, Vec::new())];
        }
        let Some(first) = first else { return Vec::new() };
        let near =
            |one: &Judged, other: &Judged| family(other.effect) == family(one.effect) && comes_as_near(other, one);
        let is_lead = |other: &&Judged| other.why_not.is_none() && family(other.effect) == family(first.effect);
        let (mut members, others): (Vec<&Judged>, Vec<&Judged>) =
            self.judged.iter().filter(is_lead).partition(|other| near(first, other));
        let nonlinear_share = |judged: &Judged| judged.nonlinear_share.unwrap_or(judged.remaining_share);
        sort_by_number(&mut members, |one| nonlinear_share(one));
        members.extend(others);
        if members[0].effect == ACCELERATION_LIMIT
            && self.limits_rate
            && let Some(place) = members.iter().position(|member| member.effect == RATE_LIMIT)
            && near(members[0], members[place])
            && total(members[place]) < AS_MUCH * total(members[0])
        {
            members[..=place].rotate_right(1);
        }
        let with_alternatives = |member: &'_ Judged| {
            let tied = self.judged.iter().filter(|other| other.effect != member.effect && near(member, other));
            tied.map(|other| other.effect.to_owned()).collect()
        };
        members.into_iter().map(|member| (member, with_alternatives(member))).collect()
    }
}

#[cfg(test)]
pub mod tests {
    use super::*;
    use crate::diagnose::{three_records::three_records, trace::Trace};
    use actuator_fmu::parameters::{Model, table};

    /// Some fit.
    pub fn some_fit() -> PlainFit {
        let given = Model::from_set(&table()[0]);
        let records = three_records(&given, 3.0);
        let traces: Vec<Trace<'_>> = records.iter().map(|record| Trace::new(record, &given.base)).collect();
        PlainFit::as_it_is(&given, &traces).unwrap()
    }

    /// An effect that leaves this share of the excess of the base and of the linear model, as if judged.
    pub fn judged(effect: &'static str, remaining_share: f64, fit: &PlainFit) -> Judged {
        Judged {
            fit: fit.clone(),
            effect,
            left: vec![remaining_share; 2],
            remaining_share,
            part: 1.0 - remaining_share,
            nonlinear_share: Some(remaining_share),
            beside_linear: vec![remaining_share; 2],
            beats_linear: true,
            of_records: Vec::new(),
            blocks: Vec::new(),
            left_in_given: None,
            why_not: None,
        }
    }

    #[test]
    fn members_of_a_family_are_tried_after_the_first_and_come_as_near_where_nothing_but_noise_stays() {
        let fit = some_fit();
        let of = |all: &[(&'static str, f64)]| Judgement {
            base: fit.clone(),
            base_left: vec![1.0; 2],
            linear_left: vec![1.0; 2],
            judged: all.iter().map(|(effect, remaining_share)| judged(effect, *remaining_share, &fit)).collect(),
            base_predictable: Predictable::default(),
            limits_rate: false,
            given_delay_s: 0.0,
            delay: None,
            base_as_late: None,
        };
        let judgement =
            of(&[("command_rate_limit", -0.2), ("acceleration_limit", -0.03), ("backlash", 0.1), ("rate_limit", 0.3)]);
        let leads: Vec<(&str, Vec<String>)> =
            judgement.leads().into_iter().map(|(lead, alternatives)| (lead.effect, alternatives)).collect();
        let names = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect::<Vec<String>>();
        assert_eq!(
            leads,
            [
                ("command_rate_limit", names(&["acceleration_limit"])),
                ("acceleration_limit", names(&["command_rate_limit"])),
                ("rate_limit", names(&["command_rate_limit", "acceleration_limit"])),
            ]
        );
    }

    #[test]
    fn a_limit_of_acceleration_that_is_one_of_the_rate_leads_as_that_where_it_leaves_hardly_less() {
        let fit = some_fit();
        let first = |limits_rate: bool, left_by_rate: f64| {
            let judgement = Judgement {
                base: fit.clone(),
                base_left: vec![1.0; 2],
                linear_left: vec![1.0; 2],
                judged: vec![judged(ACCELERATION_LIMIT, 0.01, &fit), judged(RATE_LIMIT, left_by_rate, &fit)],
                base_predictable: Predictable::default(),
                limits_rate,
                given_delay_s: 0.0,
                delay: None,
                base_as_late: None,
            };
            let (lead, others) = judgement.leads().swap_remove(0);
            (lead.effect, others)
        };
        assert_eq!(first(true, 0.012), (RATE_LIMIT, vec![ACCELERATION_LIMIT.to_owned()]));
        assert_eq!(first(true, 0.03).0, ACCELERATION_LIMIT);
        assert_eq!(first(false, 0.012).0, ACCELERATION_LIMIT);
    }

    #[test]
    fn a_delay_that_is_nearly_all_leads_before_what_takes_little_beyond_a_base_of_its_own() {
        let fit = some_fit();
        let first = |left_by_delay: f64, part: f64| {
            let friction = Judged { part, ..judged("coulomb_friction", 0.02, &fit) };
            let judgement = Judgement {
                base: fit.clone(),
                base_left: vec![1.0; 2],
                linear_left: vec![1.0; 2],
                judged: vec![friction],
                base_predictable: Predictable::default(),
                limits_rate: false,
                given_delay_s: 0.0,
                delay: Some(judged("delay", left_by_delay, &fit)),
                base_as_late: None,
            };
            judgement.leads()[0].0.effect
        };
        assert_eq!([first(0.1, 0.03), first(0.1, 0.2)], ["delay", "coulomb_friction"]);
        assert_eq!(first(0.3, 0.03), "coulomb_friction");
    }
}
