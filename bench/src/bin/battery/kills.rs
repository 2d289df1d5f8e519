//! `kill -9` of one service, two, or all, in every phase of a run.

use std::time::Duration;

use rustix::process::Signal;

use crate::attack::{Attack, Outcome, Rng};
use crate::ground::{Ground, RATE, SERVICES};

#[derive(Clone, Copy, PartialEq)]
enum Phase {
    BeforeHandOver,
    BeforeReady,
    Running,
    Drain,
}

struct Kill {
    phase: Phase,
    victims: usize,
}

/// Every phase with one, two and all services.
pub fn all() -> impl Iterator<Item = Box<dyn Attack>> {
    let phases = [
        Phase::BeforeHandOver,
        Phase::BeforeReady,
        Phase::Running,
        Phase::Drain,
    ];
    let pairs = phases
        .into_iter()
        .flat_map(|phase| [1, 2, SERVICES.len()].map(|victims| (phase, victims)));
    pairs.map(|(phase, victims)| Box::new(Kill { phase, victims }) as Box<dyn Attack>)
}

/// Permitted loss of a killed service: its start on a loaded machine. A logger also loses what it had not flushed.
const GAP: u64 = RATE;
const GAP_OF_LOGGER: u64 = 2 * RATE;

impl Attack for Kill {
    fn name(&self) -> String {
        let phase = match self.phase {
            Phase::BeforeHandOver => "before hand-over",
            Phase::BeforeReady => "before ready",
            Phase::Running => "running",
            Phase::Drain => "drain",
        };
        let victims = if self.victims == SERVICES.len() {
            "all".into()
        } else {
            self.victims.to_string()
        };
        format!("kill {victims} {phase}")
    }

    fn attempt(&mut self, rng: &mut Rng, ground: &Ground) -> Result<Outcome, String> {
        let victims = rng.some(&SERVICES, self.victims);
        let run = ground.run(
            if self.phase == Phase::Drain {
                60.0
            } else {
                4.0
            },
            &[],
        )?;
        match self.phase {
            Phase::BeforeHandOver => {}
            Phase::BeforeReady => {
                run.wait_for(victims[0])?;
                pause(rng.between(0, 40));
            }
            Phase::Running => {
                run.wait_for_all()?;
                pause(rng.between(300, 1500));
            }
            Phase::Drain => {
                run.wait_for_all()?;
                pause(rng.between(600, 1200));
                run.end();
                std::thread::sleep(Duration::from_micros(rng.between(0, 4000)));
            }
        }
        for victim in &victims {
            if self.phase == Phase::BeforeHandOver {
                run.wait_for(victim)?;
            }
            run.signal(victim, Signal::KILL);
        }
        let remains = run.remains(Duration::from_secs(12))?;
        let limit = if victims.contains(&"logger") {
            GAP_OF_LOGGER
        } else {
            GAP
        };
        let gap = remains.check(limit)?;
        let reported = victims
            .iter()
            .any(|v| remains.text.contains(&format!("{v} died")));
        if !reported && self.phase != Phase::Drain {
            return Err(format!(
                "the death of {victims:?} is not reported: {}",
                remains.text
            ));
        }
        Ok(Outcome::Survived { gap })
    }
}

fn pause(milliseconds: u64) {
    std::thread::sleep(Duration::from_millis(milliseconds));
}
