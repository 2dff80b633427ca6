//! A structural mode that is nearly all of the difference. No base imitates a resonance, so that a mode is not searched beside free bases, as effects
//! that act on the motion are: it is identified near the given base and compared with any base.

use super::{
    fitted::Fitted,
    judgement::Judgement,
    leading_oscillation::CHATTER,
    plain_fit::PlainFit,
    selection::StructureSelection,
    space::{STRUCTURAL_MODE, Space},
    trace::Trace,
    unseen::{excess, sample_counts},
};

/// Excess of a mode over that of the given model, at most, on fit and on check records. Smaller than for other leads: every actuator that moves a
/// mass has some mode, also the one to which the given model was fitted.
const GREATEST_LEFT: f64 = 0.1;

/// Excess of the free base, with a delay and levels of the records, over that of the mode, at least, on both.
const LEAST_LEFT_BY_BASE: f64 = 3.0;

/// Least damping ratio of a structure: welded metal has a thousandth, joints and bearings more.
const LEAST_DAMPING: f64 = 5e-4;

impl StructureSelection<'_> {
    /// The mode among single effects near the given base, where it leads.
    pub fn leading_mode(
        &self,
        singles: &[Fitted],
        judged: &Judgement,
        given: &Fitted,
        base: &Fitted,
    ) -> Option<Fitted> {
        let mode = singles.iter().find(|single| single.space.hypothesis.effects == [STRUCTURAL_MODE])?;
        let lead = self.refined(mode.clone());
        let is_sound = lead.space.is_plausible(&lead.model)
            && !lead.space.is_base_at_bound(&lead.x)
            && !lead.space.effect_at_bound(&lead.x)
            && share_of_mode(&lead).abs() <= 1.0
            && damping(&lead) >= LEAST_DAMPING;
        if !is_sound || self.is_line(&lead, singles)? {
            return None;
        }
        let anywhere = self.base_of_its_own(judged)?;
        let noise = self.noise.mean_squares();
        let (fitted, checked) = noise.split_at(self.fit.len().min(noise.len()));
        let takes_nearly_all = |traces: &[Trace<'_>], noise: &[f64]| {
            // A mode does not explain levels of records.
            let [of_given, of_lead] = [self.given, &lead.model].map(|model| PlainFit::beside_levels(model, traces));
            let (of_given, of_lead) = (of_given?, of_lead?);
            // Where the command rests, a mode rings on, and was taken for noise.
            let noise: Vec<f64> =
                noise.iter().zip(of_lead.mean_squares()).map(|(noise, left)| noise.min(left)).collect();
            let space = Space::new(anywhere.space.hypothesis.clone(), &anywhere.model, &self.given.base, 0.0);
            let of_base = PlainFit::at_start(space, traces)?;
            let left = |fit: &PlainFit| excess(&fit.mean_squares(), &noise, &sample_counts(fit)).max(0.0);
            let (of_given, of_lead, of_base) = (left(&of_given), left(&of_lead), left(&of_base));
            Some(of_lead < GREATEST_LEFT * of_given && LEAST_LEFT_BY_BASE * of_lead < of_base)
        };
        let leads = takes_nearly_all(&self.fit, fitted)?
            && takes_nearly_all(&self.check, checked)?
            && self.stands(&lead.clone().into(), given, base);
        leads.then_some(lead)
    }
}

impl StructureSelection<'_> {
    /// Whether a line that no command drives has as small a residual as a mode on the fit and on the check records: a mode that hardly decays rings
    /// by itself.
    fn is_line(&self, lead: &Fitted, singles: &[Fitted]) -> Option<bool> {
        let Some(line) = singles.iter().find(|single| single.space.hypothesis.effects == [CHATTER]) else {
            return Some(false);
        };
        Some(line.rms() <= lead.rms() && line.on(&self.check)?.rms() <= lead.on(&self.check)?.rms())
    }
}

/// Share of the deflection that moves with the mode: all of it at 1.
fn share_of_mode(lead: &Fitted) -> f64 {
    lead.model.effects.values_of(STRUCTURAL_MODE).and_then(|values| values.last().copied()).unwrap_or(0.0)
}

fn damping(lead: &Fitted) -> f64 {
    lead.model.effects.values_of(STRUCTURAL_MODE).map_or(0.0, |values| values[1])
}

#[cfg(test)]
mod tests {
    use crate::diagnose::{
        Verdict,
        three_records::{behind_gear, said, three_records},
    };
    use actuator_fmu::{
        effects::{Effects, find},
        parameters::{Model, table},
    };

    #[test]
    #[ignore = "slow"]
    fn a_mode_that_is_nearly_all_of_a_difference_leads_beside_an_error_that_nothing_explains() {
        let given = Model::from_set(&table()[0]);
        let of = |gain: f64| {
            let mode = find("structural_mode").unwrap();
            let truth = Model { effects: Effects::default().with(mode, &[6.0, 0.03, gain]).unwrap(), ..given.clone() };
            let records: Vec<_> = three_records(&truth, 3.0).iter().map(|record| behind_gear(record, 0.0)).collect();
            said(&given, &records)
        };
        let (verdict, found) = of(0.3);
        let (name, values, _) = found.unwrap();
        let [frequency_hz, damping, gain] = values[..] else { panic!("{values:?}") };
        assert!(verdict == Verdict::Leading && name == "structural_mode", "{verdict:?} {name}");
        assert!(
            (frequency_hz - 6.0).abs() < 0.03 && (damping - 0.03).abs() < 0.003 && (gain - 0.3).abs() < 0.02,
            "{values:?}"
        );
        assert_eq!(of(0.003), (Verdict::Unexplained, None));
    }
}
