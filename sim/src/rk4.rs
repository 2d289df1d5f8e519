//! The classical Runge-Kutta method of fourth order.

/// Position in the step at which a derivative is evaluated. A plant driven by known functions of time evaluates them once per
/// stage: at the start, in the middle (used twice) and at the end of the step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// At the beginning of the step.
    Start,
    /// Half a step later.
    Middle,
    /// At the end of the step.
    End,
}

impl Stage {
    /// The time since the beginning of the step, as a share of it.
    pub fn fraction(self) -> f64 {
        match self {
            Self::Start => 0.0,
            Self::Middle => 0.5,
            Self::End => 1.0,
        }
    }
}

/// The state after one step of length `h`, where `rate(stage, state)` is the derivative of the state.
pub fn step<const N: usize>(
    state: [f64; N],
    h: f64,
    mut rate: impl FnMut(Stage, [f64; N]) -> [f64; N],
) -> [f64; N] {
    let moved = |by: f64, k: [f64; N]| std::array::from_fn(|i| state[i] + by * k[i]);
    let k1 = rate(Stage::Start, state);
    let k2 = rate(Stage::Middle, moved(h / 2.0, k1));
    let k3 = rate(Stage::Middle, moved(h / 2.0, k2));
    let k4 = rate(Stage::End, moved(h, k3));
    std::array::from_fn(|i| state[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The error at t = 1 of x' = x cos t, x(0) = 1, whose solution is exp(sin t).
    fn error(steps: u32) -> f64 {
        let h = 1.0 / f64::from(steps);
        let end = (0..steps).fold([1.0], |x, k| {
            step(x, h, |stage, [x]| {
                [x * (h * (f64::from(k) + stage.fraction())).cos()]
            })
        });
        (end[0] - 1f64.sin().exp()).abs()
    }

    #[test]
    fn halving_the_step_divides_the_error_by_sixteen() {
        let ratio = error(20) / error(40);
        assert!((14.0..18.0).contains(&ratio), "{ratio}");
    }
}
