//! A machine by its size alone, as `--class 21t` says it.

use messages::Machine;

/// The key of a machine's mass \[kg\]: what nobody states follows from it.
pub fn mass_key(machine: Machine) -> &'static str {
    match machine {
        Machine::Excavator => "machine.operating_mass",
        Machine::Loader => "machine.mass",
    }
}
