//! Arguments of a call: often valid, otherwise anything that fits the type.

use actuator_fmu::fmu::variables::{Causality, variables};
use fastrand::Rng;
use fmi_export::Type;

/// Edge cases of arithmetic.
const NUMBERS: [f64; 22] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    0.005,
    1e-3,
    1e-9,
    1e-300,
    f64::MIN_POSITIVE,
    5e-324,
    -5e-324,
    1e7,
    -1e7,
    1e15,
    1e300,
    f64::MAX,
    f64::MIN,
    f64::EPSILON,
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    0.1,
];

const WHOLES: [i32; 12] = [0, 1, 2, 3, 4, 5, 17, 18, 255, -1, i32::MAX, i32::MIN];

/// One of these.
pub fn pick<T: Copy>(rng: &mut Rng, of: &[T]) -> T {
    of[rng.usize(..of.len())]
}

/// True in one of this many cases.
pub fn one_in(rng: &mut Rng, cases: usize) -> bool {
    rng.usize(..cases) == 0
}

/// Any number: an edge case, a usual one, or random bits.
pub fn number(rng: &mut Rng) -> f64 {
    match rng.u8(..8) {
        0..3 => pick(rng, &NUMBERS),
        3 => f64::from_bits(rng.u64(..)),
        4 => (rng.f64() - 0.5) * 10.0_f64.powi(rng.i32(-20..20)),
        _ => (rng.f64() - 0.5) * 20.0,
    }
}

/// Any whole number.
pub fn whole(rng: &mut Rng) -> i32 {
    if one_in(rng, 6) { rng.i32(..) } else { pick(rng, &WHOLES) }
}

/// Number of elements of an array; mostly few.
pub fn count(rng: &mut Rng) -> usize {
    if one_in(rng, 40) { variables().len() } else { pick(rng, &[0, 1, 1, 1, 1, 2, 3, 5, 7]) }
}

/// A step, mostly of usual size. Huge ones are rare, since they may take long.
pub fn duration(rng: &mut Rng) -> f64 {
    match rng.u16(..4000) {
        0..20 => number(rng).clamp(-10.0, 10.0),
        20..22 => number(rng),
        22..100 => pick(rng, &[5e-324, 1e-300, 1e-15, f64::NAN, -0.0, 0.0, -1.0]),
        _ => pick(rng, &[1e-4, 1e-3, 5e-3, 5e-3, 0.02, 0.1]),
    }
}

/// Type of a reference.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Of {
    /// A Real.
    Real,
    /// An Integer or an enumeration.
    Integer,
    /// A Boolean.
    Boolean,
}

fn is_of(kind: &Type, of: Of) -> bool {
    match kind {
        Type::Real { .. } => of == Of::Real,
        Type::Integer { .. } | Type::Enumeration(_) => of == Of::Integer,
        Type::Boolean => of == Of::Boolean,
    }
}

/// References: all of the type and causality, or arbitrary ones.
pub fn references(rng: &mut Rng, count: usize, of: Of, allowed: &[Causality]) -> Vec<u32> {
    let all = variables();
    if one_in(rng, 8) {
        let last = u32::try_from(all.len()).unwrap();
        return (0..count).map(|_| if one_in(rng, 5) { rng.u32(..) } else { rng.u32(..last + 3) }).collect();
    }
    let sound: Vec<u32> = (0..)
        .zip(all)
        .filter(|(_, variable)| {
            is_of(&variable.kind, of) && (allowed.is_empty() || allowed.contains(&variable.causality))
        })
        .map(|(reference, _)| reference)
        .collect();
    (0..count).map(|_| pick(rng, &sound)).collect()
}

/// A value for a variable: mostly within its range.
pub fn value_of(rng: &mut Rng, reference: u32) -> f64 {
    let variable = usize::try_from(reference).ok().and_then(|index| variables().get(index));
    let (range, nominal) = match variable.map(|variable| &variable.kind) {
        Some(Type::Real { range, nominal, .. }) => (*range, nominal.unwrap_or(1.0)),
        _ => (None, 1.0),
    };
    match (rng.u8(..16), range) {
        (0, _) | (1..4, None) => number(rng),
        (1, Some((min, max))) => pick(rng, &[min, max, min.next_up(), max.next_down(), max.next_up(), min.next_down()]),
        (2, Some((min, max))) => {
            // Logarithmically distributed between its ends, like typical parameters.
            let (least, most) = (min.abs().max(1e-6), max.abs().clamp(1e-6, 1e9));
            (least.ln() + rng.f64() * (most.ln() - least.ln())).exp().clamp(min, max)
        }
        (_, Some((min, max))) => (nominal * (rng.f64() - 0.1) * 3.0).clamp(min, max),
        (_, None) => (rng.f64() - 0.5) * 20.0,
    }
}

/// A value for an Integer, mostly within its range.
pub fn item_of(rng: &mut Rng, reference: u32) -> i32 {
    let kind = usize::try_from(reference).ok().and_then(|index| variables().get(index)).map(|variable| &variable.kind);
    match kind {
        Some(Type::Integer { min, max }) if !one_in(rng, 8) => rng.i32(*min..=*max),
        Some(Type::Enumeration(of)) if !one_in(rng, 8) => rng.i32(1..=i32::try_from(of.items.len()).unwrap()),
        _ => whole(rng),
    }
}
