//! Frequency responses from records, against the analytic ones.

use actuator_fmu::{
    frequency::{BAND_HZ, Method, estimate, response},
    parameters::{Order, table},
    signal::{Interpolation, excitation::Kind},
};

use crate::generated::{self, Generated};

#[test]
fn without_noise_local_polynomials_give_the_analytic_response() {
    for set in table() {
        for interpolation in [Interpolation::Held, Interpolation::Linear] {
            for (kind, duration_s) in
                [(Kind::Sweep, 75.0), (Kind::Random, 75.0), (Kind::Multisine, 75.0), (Kind::Sweep, 25.0)]
            {
                let record = Generated { kind, duration_s, interpolation, ..Generated::new(set.base) }.record();
                let frf = estimate(&[record], Method::Polynomial).unwrap();
                let mut worst = (0.0, 0.0);
                for point in frf.inside(BAND_HZ).filter(|point| point.excited) {
                    let exact = response(&set.base, Order::Third, point.frequency_hz);
                    let error = (point.response - exact).norm();
                    if error > worst.0 {
                        worst = (error, point.frequency_hz);
                    }
                }
                println!("{} {kind:?} {duration_s} {interpolation:?} {worst:?} {:?}", set.name, frf.excited_band_hz());
            }
        }
    }
    let _ = generated::DATA;
}
