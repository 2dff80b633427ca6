//! Prints the `modelDescription.xml` of the wing.

fn main() {
    print!("{}", bact_wing::description());
}
