//! Concluding Remarks and Appendix.

use super::{
    order_statistics::{greatest, least},
    pairs::{beyond_limits, worst_phase},
    section::{APPENDIX, CONCLUSION},
};
use crate::{
    compare::{
        comparison::Comparison,
        difference::POINTS_PER_HZ,
        statement::Statement,
        tunnel::{LOADED, Tunnel},
    },
    frequency::{BAND_HZ, phase_deg, response},
};
pub fn statements(tables: &Comparison) -> Vec<Statement> {
    vec![
        reduction(tables),
        Statement::unchecked(
            CONCLUSION,
            "models-match-over-conditions",
            "Model responses came close to measured ones over many operating conditions.",
            "The report's measured responses exist as pictures only, not as data.",
        ),
        little_change(tables),
        axes(tables),
        tunnel_range(),
    ]
}

fn reduction(tables: &Comparison) -> Statement {
    Statement::judged(
        CONCLUSION,
        "second-order-is-enough",
        "Reduction to second order changes the response negligibly in the range of the data.",
        tables.order.iter().all(|pair| pair.data_band.within_limits),
        format!("At most {:.3} deg.", worst_phase(&tables.order)),
    )
}

fn little_change(tables: &Comparison) -> Statement {
    let (wear, load) = (beyond_limits(&tables.wear).len(), beyond_limits(&tables.load).len());
    Statement::judged(
        CONCLUSION,
        "little-change",
        "Wear, servo gain and load changed the responses little.",
        wear + load == 0,
        format!(
            "{wear} of {} pairs of stages and {load} of {} pairs of load cases exceed 0.1 or 3 deg, by up to {:.1} and {:.1} deg.",
            tables.wear.len(),
            tables.load.len(),
            worst_phase(&tables.wear),
            worst_phase(&tables.load)
        ),
    )
}

fn axes(tables: &Comparison) -> Statement {
    let ([lowest, highest], phase_end) = ([0.0, 1.5], -50.0);
    let [first, last] = BAND_HZ.map(|end| (end * POINTS_PER_HZ) as u32);
    let mut leaving = Vec::new();
    for set in &tables.sets {
        let outside = (first..=last).map(|index| f64::from(index) / POINTS_PER_HZ).find(|frequency| {
            let response = response(&set.model.base, set.model.order, *frequency);
            !(lowest..=highest).contains(&response.norm()) || !(phase_end..=0.0).contains(&phase_deg(response))
        });
        if let Some(from) = outside {
            let at_end = phase_deg(response(&set.model.base, set.model.order, BAND_HZ[1]));
            leaving.push(format!("{} from {from:.2} Hz, {at_end:.1} deg at 12 Hz", set.label));
        }
    }
    Statement::judged(
        APPENDIX,
        "figures-fit-their-axes",
        "The figures show magnitudes of 0 to 1.5 and phases of -50 to 0 deg, from 0.5 to 12 Hz.",
        leaving.is_empty(),
        format!("{} of 17 curves leave these axes: {}.", leaving.len(), leaving.join("; ")),
    )
}

fn tunnel_range() -> Statement {
    let range = |of: fn(&Tunnel) -> f64| {
        let values = LOADED.iter().map(|(_, _, tunnel)| of(tunnel));
        (least(values.clone()), greatest(values))
    };
    let (mach, pressure) = (range(|tunnel| tunnel.mach), range(|tunnel| tunnel.dynamic_pressure_psf));
    Statement::judged(
        APPENDIX,
        "range-of-loaded-conditions",
        "Loaded cases span Mach 0.63 to 0.91 and 74 to 190 psf.",
        mach == (0.63, 0.91) && pressure == (74.0, 190.0),
        format!(
            "The captions of figures A8 to A10 give Mach {} to {} and {} to {} psf.",
            mach.0, mach.1, pressure.0, pressure.1
        ),
    )
}
