//! Arguments of a stage on its command line.

use crate::{Options, Primitive, WARM_UP};
use std::io;
use std::os::fd::RawFd;

/// One stage of a chain: who it is, what to do, and the descriptors it was born with.
#[derive(Debug, Clone, PartialEq)]
pub struct Assignment {
    pub kind: Primitive,
    pub stage: usize,
    pub stages: usize,
    pub period_ns: u64,
    /// All samples, those of the warm-up included.
    pub samples: usize,
    /// Size of a sample [bytes], a multiple of 8.
    pub payload: usize,
    pub work_ns: u64,
    pub fifo: bool,
    pub core: Option<usize>,
    pub parent: i32,
    pub memory: RawFd,
    /// Read end of the pipe from the stage before; -1 if there is none.
    pub input: RawFd,
    /// Write end of the pipe to the stage after; -1 if there is none.
    pub output: RawFd,
}

impl Assignment {
    /// The part of stage `stage`; descriptors are filled in by the starter.
    pub fn new(kind: Primitive, options: &Options, stage: usize) -> Self {
        Self {
            kind,
            stage,
            stages: options.stages,
            period_ns: (1e9 / options.rate_hz) as u64,
            samples: options.samples + WARM_UP,
            payload: options.payload,
            work_ns: u64::try_from(options.work.as_nanos()).unwrap_or(u64::MAX),
            fifo: options.fifo,
            core: options
                .cores
                .as_ref()
                .map(|cores| cores[stage % cores.len()]),
            parent: rustix::process::getpid().as_raw_pid(),
            memory: -1,
            input: -1,
            output: -1,
        }
    }

    /// The arguments of the process, in the order [`Assignment::from_args`] reads them.
    pub fn to_args(&self) -> Vec<String> {
        let core = self.core.map_or(-1, |core| core as i64);
        let numbers = [
            self.stage as i64,
            self.stages as i64,
            self.period_ns as i64,
            self.samples as i64,
            self.payload as i64,
            self.work_ns as i64,
            i64::from(self.fifo),
            core,
            i64::from(self.parent),
            i64::from(self.memory),
            i64::from(self.input),
            i64::from(self.output),
        ];
        let mut args = vec![self.kind.name().to_string()];
        args.extend(numbers.iter().map(i64::to_string));
        args
    }

    /// Reads the arguments back.
    pub fn from_args(args: &[String]) -> io::Result<Self> {
        parse(args).ok_or_else(|| {
            io::Error::new(
                io::ErrorKind::InvalidInput,
                "limits-worker is started by `heft latency`, not by hand",
            )
        })
    }
}

fn parse(args: &[String]) -> Option<Assignment> {
    let kind = Primitive::from_name(args.first()?)?;
    let numbers: Vec<i64> = args[1..]
        .iter()
        .map(|arg| arg.parse().ok())
        .collect::<Option<_>>()?;
    let [
        stage,
        stages,
        period,
        samples,
        payload,
        work,
        fifo,
        core,
        parent,
        memory,
        input,
        output,
    ] = numbers[..]
    else {
        return None;
    };
    let assignment = Assignment {
        kind,
        stage: usize::try_from(stage).ok()?,
        stages: usize::try_from(stages).ok()?,
        period_ns: u64::try_from(period).ok()?,
        samples: usize::try_from(samples).ok()?,
        payload: usize::try_from(payload).ok()?,
        work_ns: u64::try_from(work).ok()?,
        fifo: fifo == 1,
        core: usize::try_from(core).ok(),
        parent: i32::try_from(parent).ok()?,
        memory: RawFd::try_from(memory).ok()?,
        input: RawFd::try_from(input).ok()?,
        output: RawFd::try_from(output).ok()?,
    };
    (assignment.stage < assignment.stages && assignment.payload >= 8 * (1 + assignment.stages))
        .then_some(assignment)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_assignment_survives_the_command_line() {
        let options = Options {
            cores: Some(vec![0, 1]),
            ..Options::default()
        };
        for stage in 0..4 {
            let assignment = Assignment::new(Primitive::Pipe, &options, stage);
            assert_eq!(
                Assignment::from_args(&assignment.to_args()).ok(),
                Some(assignment)
            );
        }
    }

    #[test]
    fn other_arguments_are_refused() {
        assert!(Assignment::from_args(&["futex".to_string(), "1".to_string()]).is_err());
        assert!(Assignment::from_args(&[]).is_err());
    }
}
