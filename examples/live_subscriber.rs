//! A subscriber of a running pipeline: `heft run excavator --domain demo`, and in another terminal
//! `cargo run --example live_subscriber demo`.

use std::error::Error;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use messages::ExcavatorEstimate;
use messages::channels::EXCAVATOR_INERTIA_UKF;
use messages::excavator_bits::TRUSTED;
use runtime::{Domain, Ports};

fn main() -> ExitCode {
    let Err(error) = run() else {
        return ExitCode::SUCCESS;
    };
    eprintln!("{error}");
    ExitCode::from(2)
}

fn run() -> Result<(), Box<dyn Error>> {
    let Some(name) = std::env::args().nth(1) else {
        return Err("usage: live_subscriber DOMAIN, that of a running pipeline".into());
    };
    Domain::new(&name)?.enter()?;
    let channel = &EXCAVATOR_INERTIA_UKF;
    let mut input = Ports::new("example")?.input::<ExcavatorEstimate>(channel, channel.depth)?;
    input.connect();
    let end = Instant::now() + Duration::from_secs(10);
    while Instant::now() < end {
        while let Some((estimate, lost)) = input.receive() {
            let word = if estimate.flags & TRUSTED != 0 {
                "trusted"
            } else {
                "not trusted"
            };
            println!(
                "{:7.2} s  {:7.0} kg m²  {word}, {lost} lost",
                estimate.stamp.time, estimate.inertia
            );
        }
        std::thread::sleep(Duration::from_millis(100));
    }
    Ok(())
}
