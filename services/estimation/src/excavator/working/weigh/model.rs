//! The moment as a measurement: prediction of the friction's rest, the expected moment with its row, the update.

use super::super::filter::{BUCKET, Filter, GAIN, HELD, LINKS, M, N, REST, SLOPE, SPAN, ZERO};
use super::super::trail::Trail;
use super::{GATE, Weigh, fits};
use crate::excavator::measurements::boom_moment::Moment;
use crate::excavator::settings::Settings;
use crate::kalman::Innovation;

/// Standard deviation of the load's centre, as a share of its distance from the bucket pin.
const CENTRE: f64 = 0.12;
/// Time in which zero, span and held friction wander by their stated standard deviations \[s\].
const LASTING: f64 = 3600.0;

impl Weigh {
    /// Predicts the rest of the friction, and adds the random walks of zero, span and held friction.
    fn wander(
        &self,
        m: &Moment,
        filter: &mut Filter,
        settings: &Settings,
        trail: &mut Option<Trail>,
    ) {
        let c = &self.cylinder;
        let doubt = if m.moves { c.friction[1] } else { 0.0 };
        let load = filter.load().max(0.0) * m.per_payload / m.lever;
        let centre =
            CENTRE * settings.geometry.payload_centre / settings.geometry.lengths[0] * load;
        let variance = m.rest(c.friction[0]) + doubt * doubt + centre * centre;
        let decay = m.kept();
        if let Some(trail) = trail {
            let mut row = [0.0; N];
            row[REST] = decay;
            trail.row(REST, &row);
        }
        filter.x[REST] *= decay;
        for i in 0..N {
            filter.p[REST][i] *= decay;
            filter.p[i][REST] *= decay;
        }
        // The unknown part of the seals' friction changes with the direction of motion.
        let turned = m.turned * c.friction[1];
        filter.p[REST][REST] += (1.0 - decay * decay) * variance + turned * turned;
        let lost = m.period / LASTING;
        filter.p[ZERO][ZERO] += lost * c.zero_std * c.zero_std;
        filter.p[SPAN][SPAN] += lost * c.span_std * c.span_std;
        filter.p[HELD][HELD] += lost * c.held_variance();
    }

    /// Returns the expected moment and its row.
    pub(in crate::excavator) fn model(
        &self,
        filter: &Filter,
        m: &Moment,
    ) -> (f64, [(usize, f64); 10]) {
        let x = &filter.x;
        let [sin, cos] = m.turn;
        // Pitch of the upper body, from the slope of the ground in the axes of the start.
        let pitch = -(x[SLOPE] * sin + x[SLOPE + 1] * cos);
        let [of_load, of_gain] = filter.load_row();
        let payload = filter.load();
        let tilt = m.tilt + payload * m.tilt_payload;
        let load = m.per_payload + pitch * m.tilt_payload;
        let tau = m.empty
            + x[LINKS] * m.links
            + x[BUCKET] * m.per_bucket
            + payload * load
            + pitch * m.tilt;
        let span = 1.0 + x[SPAN];
        let held = if m.moves { 0.0 } else { m.side };
        let friction = self.cylinder.friction[0] * m.direction + x[HELD] * held;
        let expected = span * tau + m.lever * (x[ZERO] + x[REST] + friction);
        let row = [
            (M, span * load * of_load.1),
            (GAIN, span * load * of_gain.1),
            (BUCKET, span * m.per_bucket),
            (LINKS, span * m.links),
            (SPAN, tau),
            (ZERO, m.lever),
            (REST, m.lever),
            (HELD, m.lever * held),
            (SLOPE, -span * tilt * sin),
            (SLOPE + 1, -span * tilt * cos),
        ];
        (expected, row)
    }

    /// Predicts the friction, updates the filter with a moment, and returns the innovation. There is no update where the filter does not
    /// trust the pressures, beyond the gate, or where the ground may carry part of the load.
    pub(in crate::excavator) fn measure(
        &self,
        settings: &Settings,
        m: &Moment,
        (filter, believes): (&mut Filter, bool),
        trail: &mut Option<Trail>,
    ) -> Innovation {
        self.wander(m, filter, settings, trail);
        let (expected, row) = self.model(filter, m);
        let value = m.measured - expected;
        let measured = filter.measured(row);
        let innovation = Innovation {
            value,
            variance: measured.variance + m.variance,
        };
        if believes && !m.touches && fits(innovation) {
            let before = filter.x[M];
            filter.absorb(&measured, innovation, GATE, trail);
            filter.weighs_true_mass(before, trail);
        }
        innovation
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{MOMENT, described};
    use super::*;
    use crate::excavator::keys::Description;
    use crate::math::sqrt;

    /// Moments of a boom that is raised and lowered alternately for 1 s each, with stands of 1 s, under this load \[kg\]. A stop leaves
    /// the share `kept` of the friction \[N\].
    fn lifts(load: f64, friction: f64, kept: f64) -> impl Iterator<Item = Moment> {
        (0..800).map(move |block: u32| {
            let side = if (block / 10).is_multiple_of(2) {
                1.0
            } else {
                -1.0
            };
            let moves = block % 10 < 5;
            let (lever, per_payload) = (0.5, 40.0);
            let left = if moves { friction } else { kept * friction };
            let starts = block.is_multiple_of(10);
            Moment {
                measured: MOMENT + per_payload * load + lever * side * left,
                empty: MOMENT,
                per_payload,
                lever,
                side,
                // The description states that half of it is left.
                direction: if moves { side } else { 0.5 * side },
                moves,
                turned: if starts || block % 10 == 5 { 1.0 } else { 0.0 },
                variance: 200.0 * 200.0,
                period: 0.2,
                ..Moment::default()
            }
        })
    }

    #[test]
    fn what_a_stop_leaves_of_the_friction_is_learnt_and_is_no_load() {
        for kept in [0.0, 1.0] {
            let weigh = described();
            let [friction, _] = weigh.cylinder.friction;
            let settings = Settings::of(&Description::default());
            let mut filter = Filter::new([0.0; N], &[0.0; N]);
            let before = weigh.cylinder.held_variance();
            filter.set(HELD, 0.0, before, &mut None);
            filter.set(M, 0.0, 1e6, &mut None);
            for moment in lifts(500.0, friction, kept) {
                weigh.measure(&settings, &moment, (&mut filter, true), &mut None);
            }
            let off = filter.x[HELD] - (kept - 0.5) * friction;
            let std = sqrt(filter.p[HELD][HELD]);
            assert!(off.abs() < 2.0 * std, "{kept}: {off} +- {std}");
            assert!(std < 0.5 * sqrt(before), "{kept}: {std}");
            let off = filter.load() - 500.0;
            assert!(off.abs() < 2.0 * sqrt(filter.p[M][M]), "{kept}: {off}");
        }
    }
}
