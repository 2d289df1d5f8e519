//! Machine described by its size alone, as with `--class 21t`.

use messages::Machine;

/// The key of a machine's mass \[kg\], from which the values that are not stated follow.
pub fn mass_key(machine: Machine) -> &'static str {
    match machine {
        Machine::Excavator => "machine.operating_mass",
        Machine::Loader => "machine.mass",
    }
}

/// Mass of the reference machine \[kg\].
pub fn reference_mass(machine: Machine) -> f64 {
    match machine {
        Machine::Excavator => crate::Excavator::REFERENCE_MASS,
        Machine::Loader => crate::Loader::REFERENCE_MASS,
    }
}
