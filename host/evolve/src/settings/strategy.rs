//! Values that the evolution strategies share: `cma-es`, `sep-cma-es` and `open-es`.

use oneiro::parameter::Allowed::{Any, Number};
use oneiro::parameter::{Parameter, row};
use serde::{Serialize, Serializer};

use super::{Feature, Settings};

/// Values of evolution strategies.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Strategy {
    /// Standard deviation of the first samples, or of all, in halves of the initial range; given once complete.
    pub sigma: Option<f64>,
    /// Whether the worse half of the samples shrinks the covariances.
    pub active: bool,
    /// Whether a strategy that can't go on begins again.
    pub restarts: bool,
    /// Adam's step; given once complete. Other optimisers' saved states have the hash of an earlier default.
    #[serde(serialize_with = "or_earlier")]
    pub learning_rate: Option<f64>,
    /// How strongly genes are drawn to the middle of their initial range.
    pub weight_decay: f64,
}

impl Default for Strategy {
    fn default() -> Self {
        Self {
            sigma: None,
            active: true,
            restarts: true,
            learning_rate: None,
            weight_decay: 0.005,
        }
    }
}

#[allow(clippy::ref_option, reason = "serde passes it like this")]
fn or_earlier<S: Serializer>(rate: &Option<f64>, serializer: S) -> Result<S::Ok, S::Error> {
    rate.unwrap_or(0.01).serialize(serializer)
}

/// Values that are the experiment's only with some optimisers.
impl Settings {
    /// With an evolution strategy.
    pub(crate) fn strategy(&mut self) -> Option<&mut Strategy> {
        (self.is(Feature::AdaptsCovariances) || self.is(Feature::FollowsGradient)).then_some(&mut self.strategy)
    }

    /// With an evolution strategy that adapts covariances.
    pub(crate) fn if_adapts_covariances(&mut self) -> Option<&mut Strategy> {
        self.is(Feature::AdaptsCovariances).then_some(&mut self.strategy)
    }

    /// With an evolution strategy that follows a gradient.
    pub(crate) fn if_follows_gradient(&mut self) -> Option<&mut Strategy> {
        self.is(Feature::FollowsGradient).then_some(&mut self.strategy)
    }
}

/// Rows of these values.
#[rustfmt::skip]
pub(crate) fn rows<T: AsMut<Settings>>() -> Vec<Parameter<T>> {
    vec![
        row("evolution.strategy.sigma", "", Number(1e-6, 1e6), "ours (docs/optimisers.md); 0.02 in evorobotpy2 with open-es",
            "Standard deviation of the samples, of cma-es and sep-cma-es in the beginning, in halves of the initial range; default: 0.5, but 0.8 with open-es.", |values, _| Some(&mut values.as_mut().strategy()?.sigma)),
        row("evolution.strategy.active", "", Any, "Hansen 2016, and the package cma 4.5.0",
            "Whether the worse half of the samples also changes the covariances, with negative weights.", |values, _| Some(&mut values.as_mut().if_adapts_covariances()?.active)),
        row("evolution.strategy.restarts", "", Any, "Hansen 2016, appendix B.3",
            "Whether a strategy that can't continue, or has not improved for long, restarts elsewhere with as many individuals.", |values, _| Some(&mut values.as_mut().if_adapts_covariances()?.restarts)),
        row("evolution.strategy.learning_rate", "", Number(1e-9, 1e3), "ours (docs/optimisers.md); 0.01 in evorobotpy2",
            "Adam's step, in halves of the initial range; default: 0.3.", |values, _| Some(&mut values.as_mut().if_follows_gradient()?.learning_rate)),
        row("evolution.strategy.weight_decay", "", Number(0.0, 1e3), "Salimans et al. 2017",
            "Pull to the middle of the initial range: this fraction of the distance is subtracted from the gradient.", |values, _| Some(&mut values.as_mut().if_follows_gradient()?.weight_decay)),
    ]
}
