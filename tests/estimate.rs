//! dev
use actuator_fmu::{parameters::{Base, table}, estimate::*, signal::{record::*, excitation::Kind}};
use crate::generated::Generated;
use std::time::Instant;

fn show(name: &str, truth: [f64;4], fit: &Fit, t: std::time::Duration) {
    print!("{name:<20} {:5.0} ms rms {:.5} ar {} {:?} ", t.as_secs_f64()*1e3, fit.residual_rms, fit.noise_order, fit.pole);
    for e in &fit.estimates {
        let i = ["k","p","omega","zeta"].iter().position(|n| *n==e.name);
        match i { Some(i) => print!("{} {:+.3}% se {:.3}%; ", e.name, 100.0*(e.value/truth[i]-1.0), 100.0*e.std_error.unwrap_or(f64::NAN)/e.value),
          None => print!("{} {:.6} se {:.6}; ", e.name, e.value, e.std_error.unwrap_or(f64::NAN)) }
    }
    println!("order {:?} ev {:?} its {:?} bad {}", fit.model.order, fit.evidence.iter().map(|e| (e.model.clone(), e.delta_bic.round())).collect::<Vec<_>>(), fit.starts.iter().map(|s| s.iterations).collect::<Vec<_>>(), fit.starts.iter().filter(|s| !s.at_best).count());
}

#[test]
fn dev_all() {
    for d in [75.0, 25.0] {
    for set in table().iter().take(17) {
        let r = Generated { noise: 0.02, duration_s: d, ..Generated::new(set.base) }.record();
        let t = Instant::now();
        let fit = fit(&[r], &Settings::default()).unwrap();
        show(&set.name.to_string(), set.base.values(), &fit, t.elapsed());
        if set.name.to_string().contains("early") && fit.notes.len()>0 { println!("{:?} {:?} {:?}", fit.notes, fit.not_identifiable, fit.correlations); }
    }}
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
        for e in &fit.estimates { print!("{:e} ", e.value / set.base.values()[["k","p","omega","zeta"].iter().position(|n| *n==e.name).unwrap()] - 1.0); }
        println!();
    }
}
#[test]
fn dev_mts() {
    for f in ["chirp_0A.csv", "chirp_1A.csv"] {
        let t = Instant::now();
        let r = Record::read(&std::path::Path::new("/work/shared/data/mts_servohydraulic").join(f), &Format { columns: "time=t_s,command=cmd_mm,position=pos_mm".parse().unwrap(), unit: Unit::Millimetre, ..Default::default() }).unwrap();
        println!("=== {f} {} {:?}", r.len(), t.elapsed());
        for (o, d) in [(OrderChoice::Second, DelayChoice::Free), (OrderChoice::Auto, DelayChoice::Free), (OrderChoice::Auto, DelayChoice::default())] {
        let t = Instant::now();
        let fit = fit(std::slice::from_ref(&r), &Settings { order: o, delay: d, ..Default::default() }).unwrap();
        show(f, [1.0;4], &fit, t.elapsed());
        println!("{:?} {:?} {:?}", fit.notes, fit.not_identifiable, fit.model.base);
        }
    }
}
