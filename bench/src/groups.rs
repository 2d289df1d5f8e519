//! Groups of compared filters, and the targets.

use crate::bounds::{self, Operations};
use crate::measure::{Contender, contender, custom};
use crate::problem::{Filter, SAMPLES, regression_data, rover_data, velocity_data};
use crate::wide::{Batch, LANES, LaneSample, Path};
use crate::{ours, peers};

/// Role of a contender in its group.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// Ours, the numerator of the ratio.
    Ours,
    /// Another form of ours.
    Variant,
    /// A peer of the same kind.
    Peer,
    /// A peer of another kind that is an alternative.
    Other,
}

/// Contenders on one problem.
pub struct Group {
    /// The key in the JSON.
    pub key: &'static str,
    /// The heading in the table.
    pub title: &'static str,
    /// Highest allowed ratio of ours to the best peer.
    pub target: f64,
    /// Operations of one step.
    pub operations: Operations,
    /// Contenders, ours first.
    pub contenders: Vec<Contender>,
    /// Role of each contender.
    pub roles: Vec<Role>,
}

impl Group {
    fn new(key: &'static str, title: &'static str, target: f64, operations: Operations) -> Self {
        Self {
            key,
            title,
            target,
            operations,
            contenders: Vec::new(),
            roles: Vec::new(),
        }
    }

    fn with<F, Z, const N: usize>(mut self, role: Role, name: &'static str, data: &[Z]) -> Self
    where
        F: Filter<Z, N> + Default + 'static,
        Z: Clone + 'static,
    {
        self.contenders
            .push(contender::<F, Z, N>(name, data.to_vec()));
        self.roles.push(role);
        self
    }
}

/// Kalman filter, two states, one measurement.
pub fn kalman() -> Group {
    use peers::kalman::{Adskalman, Kfilter, Minikalman, Numeris, Smelly, Textbook};
    let data = velocity_data();
    Group::new("kf_2_1", "Kalman filter 2/1", 0.8, bounds::KALMAN)
        .with::<ours::Kalman, _, 2>(Role::Ours, "ours", &data)
        .with::<Smelly, _, 2>(Role::Peer, "smelly 0.2.0", &data)
        .with::<Kfilter, _, 2>(Role::Peer, "kfilter 0.5.1", &data)
        .with::<Minikalman, _, 2>(Role::Peer, "minikalman 0.8.1", &data)
        .with::<Numeris, _, 2>(Role::Peer, "numeris 0.6.0 (EKF)", &data)
        .with::<Adskalman, _, 2>(Role::Peer, "adskalman 0.18.0", &data)
        .with::<Textbook, _, 2>(Role::Peer, "textbook nalgebra", &data)
}

/// Recursive least squares, three parameters.
pub fn regression() -> Group {
    use peers::regression::{SingleFactor, TextbookSolve};
    let data = regression_data();
    Group::new(
        "rls_3",
        "RLS, 3 parameters, a factor each",
        0.5,
        bounds::REGRESSION,
    )
    .with::<ours::Regression<false>, _, 3>(Role::Ours, "ours, closed form", &data)
    .with::<ours::Regression<true>, _, 3>(Role::Variant, "ours, 3x3 solve", &data)
    .with::<SingleFactor, _, 3>(Role::Peer, "single factor, textbook nalgebra", &data)
    .with::<TextbookSolve, _, 3>(Role::Other, "a factor each, nalgebra LU", &data)
}

/// Square-root unscented filter, six states, three measurements.
pub fn unscented() -> Group {
    use peers::unscented::{Kfilter, Minikalman, NumerisSrUkf, NumerisUkf, Smelly, Textbook};
    let data = rover_data();
    Group::new("srukf_6_3", "Square-root UKF 6/3", 0.35, bounds::UNSCENTED)
        .with::<ours::Unscented, _, 6>(Role::Ours, "ours", &data)
        .with::<peers::square_root::Textbook, _, 6>(Role::Peer, "textbook nalgebra SR-UKF", &data)
        .with::<NumerisSrUkf, _, 6>(Role::Other, "numeris 0.6.0 (factors anew)", &data)
        .with::<Minikalman, _, 6>(Role::Other, "plain: minikalman 0.8.1", &data)
        .with::<Kfilter, _, 6>(Role::Other, "plain: kfilter 0.5.1", &data)
        .with::<Smelly, _, 6>(Role::Other, "plain: smelly 0.2.0", &data)
        .with::<NumerisUkf, _, 6>(Role::Other, "plain: numeris 0.6.0", &data)
        .with::<Textbook, _, 6>(Role::Other, "plain: textbook nalgebra", &data)
}

/// Extended Kalman filter, six states, three measurements.
pub fn extended() -> Group {
    use peers::extended::{Kfilter, Numeris, Smelly, Textbook};
    let data = rover_data();
    Group::new("ekf_6_3", "EKF 6/3", 0.7, bounds::EXTENDED)
        .with::<ours::Extended, _, 6>(Role::Ours, "ours (covariance)", &data)
        .with::<Kfilter, _, 6>(Role::Peer, "kfilter 0.5.1", &data)
        .with::<Smelly, _, 6>(Role::Peer, "smelly 0.2.0", &data)
        .with::<Numeris, _, 6>(Role::Peer, "numeris 0.6.0", &data)
        .with::<Textbook, _, 6>(Role::Peer, "textbook nalgebra", &data)
}

/// Highest allowed ratio of the cost per machine in a batch to a single step.
pub const BATCH_TARGET: f64 = 0.35;

/// The single step, then batches of eight machines on every path of this machine.
pub fn batches() -> Vec<Contender> {
    let data = rover_data();
    let lanes: Vec<LaneSample> = (0..SAMPLES)
        .map(|k| LaneSample::of(std::array::from_fn(|lane| data[(k + 31 * lane) % SAMPLES])))
        .collect();
    let mut contenders = vec![contender::<ours::Unscented, _, 6>("single", data)];
    for path in Path::available() {
        let (mut batch, lanes) = (Batch::new(path), lanes.clone());
        let block = move || {
            batch.run(std::hint::black_box(&lanes));
            std::hint::black_box(batch.state(0));
            (LANES * SAMPLES) as u64
        };
        contenders.push(custom(path.name(), block, || ()));
    }
    contenders
}

/// All comparisons with peers.
pub fn all() -> Vec<Group> {
    vec![kalman(), regression(), unscented(), extended()]
}
