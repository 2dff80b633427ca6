//! dev
use crate::generated::Generated;
use actuator_fmu::{
    estimate::*,
    parameters::{Base, table},
    signal::{excitation::Kind, record::*},
};
use std::time::Instant;

fn show(name: &str, truth: [f64; 4], fit: &Fit, t: std::time::Duration) {
    print!(
        "{name:<20} {:5.0} ms rms {:.5} ar {} {:?} ",
        t.as_secs_f64() * 1e3,
        fit.residual_rms,
        fit.noise_order,
        fit.pole
    );
    for e in &fit.estimates {
        let i = ["k", "p", "omega", "zeta"].iter().position(|n| *n == e.name);
        match i {
            Some(i) => print!(
                "{} {:+.3}% se {:.3}%; ",
                e.name,
                100.0 * (e.value / truth[i] - 1.0),
                100.0 * e.std_error.unwrap_or(f64::NAN) / e.value
            ),
            None => print!("{} {:.6} se {:.6}; ", e.name, e.value, e.std_error.unwrap_or(f64::NAN)),
        }
    }
    println!(
        "order {:?} ev {:?} its {:?} bad {}",
        fit.model.order,
        fit.evidence.iter().map(|e| (e.model.clone(), e.delta_bic.round())).collect::<Vec<_>>(),
        fit.starts.iter().map(|s| s.iterations).collect::<Vec<_>>(),
        fit.starts.iter().filter(|s| !s.at_best).count()
    );
}

#[test]
fn dev_all() {
    for d in [75.0, 25.0] {
        for set in table().iter().take(17) {
            let r = Generated { noise: 0.02, duration_s: d, ..Generated::new(set.base) }.record();
            let t = Instant::now();
            let fit = fit(&[r], &Settings::default()).unwrap();
            show(&set.name.to_string(), set.base.values(), &fit, t.elapsed());
            if set.name.to_string().contains("early") && !fit.notes.is_empty() {
                println!("{:?} {:?} {:?}", fit.notes, fit.not_identifiable, fit.correlations);
            }
        }
    }
}
#[test]
fn dev_p200() {
    for set in table().iter() {
        let b = Base::new(set.base.k(), 200.0, set.base.omega(), set.base.zeta()).unwrap();
        let r = Generated { noise: 0.02, duration_s: 75.0, ..Generated::new(b) }.record();
        let t = Instant::now();
        let fit = fit(&[r], &Settings::default()).unwrap();
        show(&set.name.to_string(), b.values(), &fit, t.elapsed());
    }
}
#[test]
fn dev_clean() {
    for set in table().iter() {
        let r = Generated { noise: 0.0, duration_s: 75.0, ..Generated::new(set.base) }.record();
        let t = Instant::now();
        let fit = fit(&[r], &Settings::default()).unwrap();
        show(&set.name.to_string(), set.base.values(), &fit, t.elapsed());
        for e in &fit.estimates {
            print!(
                "{:e} ",
                e.value / set.base.values()[["k", "p", "omega", "zeta"].iter().position(|n| *n == e.name).unwrap()]
                    - 1.0
            );
        }
        println!();
    }
}
#[test]
fn dev_mts() {
    for f in ["chirp_0A.csv", "chirp_1A.csv"] {
        let t = Instant::now();
        let r = Record::read(
            &std::path::Path::new("/work/shared/data/mts_servohydraulic").join(f),
            &Format {
                columns: "time=t_s,command=cmd_mm,position=pos_mm".parse().unwrap(),
                unit: Unit::Millimetre,
                ..Default::default()
            },
        )
        .unwrap();
        println!("=== {f} {} {:?}", r.len(), t.elapsed());
        for (o, d) in [
            (OrderChoice::Second, DelayChoice::Free),
            (OrderChoice::Auto, DelayChoice::Free),
            (OrderChoice::Auto, DelayChoice::default()),
        ] {
            let t = Instant::now();
            let fit = fit(std::slice::from_ref(&r), &Settings { order: o, delay: d, ..Default::default() }).unwrap();
            show(f, [1.0; 4], &fit, t.elapsed());
            println!("{:?} {:?} {:?}", fit.notes, fit.not_identifiable, fit.model.base);
        }
    }
}
#[test]
fn dev_report() {
    for (d, n) in [(75.0, 0.0), (75.0, 0.02), (25.0, 0.0), (25.0, 0.02)] {
        for unit in [PhaseUnit::Degree, PhaseUnit::Radian] {
            for kind in [Kind::Sweep, Kind::Random] {
                println!("== {d} {n} {unit:?} {kind:?}");
                for set in table().iter().take(17) {
                    let r = Generated { kind, noise: n, duration_s: d, ..Generated::new(set.base) }.record();
                    let t = Instant::now();
                    let fit = fit(&[r], &Settings { method: Method::Report, phase_unit: unit, ..Default::default() })
                        .unwrap();
                    let c = fit.starts.iter().filter(|s| s.converged).count() as f64 / fit.starts.len() as f64;
                    print!(
                        "conv {c:.2} p {:.1} cost {:.3e} ",
                        fit.model.base.p(),
                        fit.starts.iter().map(|s| s.cost).fold(f64::INFINITY, f64::min)
                    );
                    show(&set.name.to_string(), set.base.values(), &fit, t.elapsed());
                }
            }
        }
    }
}
#[test]
fn dbg_report() {
    let set = table()[0];
    let r = Generated { ..Generated::new(set.base) }.record();
    let fit = fit(&[r], &Settings { method: Method::Report, ..Default::default() }).unwrap();
    for s in &fit.starts {
        println!("{:?} -> {:?} {} {} {}", s.start, s.end, s.cost, s.iterations, s.ending);
    }
    let set = table().iter().find(|s| s.name.to_string() == "te-middle-loaded").unwrap();
    let r = Generated { ..Generated::new(set.base) }.record();
    let frf = actuator_fmu::frequency::estimate(&[r], actuator_fmu::frequency::Method::Report).unwrap();
    println!("{:?}", frf.notes);
    for p in frf.points.iter().step_by(6) {
        let e = actuator_fmu::frequency::response(&set.base, actuator_fmu::parameters::Order::Third, p.frequency_hz);
        println!(
            "{:.3} {:.4} {:.2} true {:.4} {:.2} coh {:.3}",
            p.frequency_hz,
            p.response.norm(),
            p.response.arg().to_degrees(),
            e.norm(),
            e.arg().to_degrees(),
            p.coherence
        );
    }
}
