//! A stopped service: for a moment, for ever, and while the run ends.

use std::time::{Duration, Instant};

use rustix::process::Signal;

use crate::attack::{Attack, Outcome, Rng};
use crate::ground::{Ground, RATE, SERVICES};

#[derive(Clone, Copy, PartialEq)]
enum Length {
    Short,
    Forever,
    AtTheEnd,
}

struct Stop(Length);

/// Three lengths.
pub fn all() -> impl Iterator<Item = Box<dyn Attack>> {
    let lengths = [Length::Short, Length::Forever, Length::AtTheEnd];
    lengths
        .into_iter()
        .map(|length| Box::new(Stop(length)) as Box<dyn Attack>)
}

impl Attack for Stop {
    fn name(&self) -> String {
        match self.0 {
            Length::Short => "stop for up to 0.3 s".into(),
            Length::Forever => "stop for ever".into(),
            Length::AtTheEnd => "stop all and end".into(),
        }
    }

    fn attempt(&mut self, rng: &mut Rng, ground: &Ground) -> Result<Outcome, String> {
        let run = ground.run(
            if self.0 == Length::AtTheEnd {
                60.0
            } else {
                5.0
            },
            &[],
        )?;
        run.wait_for_all()?;
        std::thread::sleep(Duration::from_millis(rng.between(400, 1000)));
        let victim = rng.one(&SERVICES);
        match self.0 {
            Length::Short => {
                run.signal(victim, Signal::STOP);
                std::thread::sleep(Duration::from_millis(rng.between(10, 300)));
                run.signal(victim, Signal::CONT);
                let remains = run.remains(Duration::from_secs(10))?;
                if remains.text.contains("hung") {
                    return Err(format!("{victim} was ended for a nap: {}", remains.text));
                }
                let gap = remains.check(RATE)?;
                Ok(Outcome::Survived { gap })
            }
            Length::Forever => {
                let old = run.wait_for(victim)?;
                let begun = Instant::now();
                run.signal(victim, Signal::STOP);
                while run.service(victim).is_none_or(|pid| pid == old) {
                    if begun.elapsed() > Duration::from_secs(2) {
                        return Err(format!("{victim} still stands after 2 s: {}", run.text()));
                    }
                    std::thread::sleep(Duration::from_millis(5));
                }
                let remains = run.remains(Duration::from_secs(10))?;
                if remains.status != 1 || !remains.text.contains(&format!("{victim} hung")) {
                    return Err(format!("status {}: {}", remains.status, remains.text));
                }
                let gap = remains.check(3 * RATE)?;
                Ok(Outcome::Survived { gap })
            }
            Length::AtTheEnd => {
                SERVICES
                    .iter()
                    .for_each(|name| run.signal(name, Signal::STOP));
                run.end();
                let remains = run.remains(Duration::from_millis(5500))?;
                if remains.status != 1 {
                    return Err(format!("status {}: {}", remains.status, remains.text));
                }
                Ok(Outcome::Survived { gap: 0 })
            }
        }
    }
}
