//! The methods that are compared.

use sindyna_record::comparison::base;
use sindyna_report::method_name;
use sindyna_training::Error;

/// A way from nothing to a policy.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Method {
    /// What `sindyna train` does.
    Sindy,
    /// The same loop with a linear model, fitted by least squares.
    LeastSquares,
    /// The same loop with an ensemble of neural networks, Janner's.
    Ensemble,
    /// Soft actor-critic on the system, one update a step.
    Sac,
    /// The same with twenty.
    Sac20,
    /// Soft actor-critic that adds to its real data what an ensemble of neural networks imagines, with Janner's settings.
    Mbpo,
    /// The same with the ensemble whose size the paper gives.
    MbpoPaper,
    /// MBPO with identified equations instead of the ensemble.
    SindyMbpo,
    /// Soft actor-critic inside the true equations, known beforehand: what the best of models could give.
    Oracle,
    /// A linear-quadratic regulator of a linear model, fitted by least squares to six times five steps of small random pushes.
    Lqr,
    /// A linear-quadratic regulator of the equations that `sindy` identifies from its first steps.
    SindyLqr,
    /// A controller that somebody wrote who knows the equations.
    Expert,
    /// Uniformly random actions.
    Random,
}

impl Method {
    /// All of them, in the order of tables.
    pub const ALL: [Self; 13] = [
        Self::Sindy,
        Self::LeastSquares,
        Self::Ensemble,
        Self::SindyMbpo,
        Self::Mbpo,
        Self::MbpoPaper,
        Self::Sac,
        Self::Sac20,
        Self::Oracle,
        Self::SindyLqr,
        Self::Lqr,
        Self::Expert,
        Self::Random,
    ];

    /// What the user calls it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Sindy => "sindy",
            Self::LeastSquares => "least-squares",
            Self::Ensemble => "ensemble",
            Self::SindyMbpo => "sindy-mbpo",
            Self::Mbpo => "mbpo",
            Self::MbpoPaper => "mbpo-paper",
            Self::Sac => "sac",
            Self::Sac20 => "sac20",
            Self::Oracle => "oracle",
            Self::SindyLqr => "sindy-lqr",
            Self::Lqr => "lqr",
            Self::Expert => "expert",
            Self::Random => "random",
        }
    }

    /// The method called `name`, or once called so (`truth`, `hand`).
    pub fn named(name: &str) -> Result<Self, Error> {
        let known = Self::ALL.map(Self::name);
        let called = method_name(name);
        Self::ALL.into_iter().find(|m| m.name() == called).ok_or_else(|| Error::UnknownName {
            what: "method",
            name: name.to_owned(),
            known: known.map(String::from).to_vec(),
        })
    }

    /// The method of a run called `name`, which may be a variant.
    pub fn of_run(name: &str) -> Option<Self> {
        let name = method_name(base(name));
        Self::ALL.into_iter().find(|method| method.name() == name)
    }

    /// Whether the method can be used on the task called `task`: a regulator needs something to balance, and not everybody
    /// has written a controller for everything.
    pub fn fits(self, task: &str) -> bool {
        match self {
            Self::Lqr | Self::SindyLqr => ["cart-pole", "inverted-pendulum"].contains(&task),
            Self::Expert => sindyna_control::ByHand::new(task).is_some(),
            _ => true,
        }
    }

    /// Whether real steps say nothing of the method: it knows what others have to learn, or learns nothing.
    pub fn is_reference(self) -> bool {
        matches!(self, Self::Oracle | Self::Expert | Self::Random)
    }

    /// Whether the method goes on acting on the system until its budget is spent.
    pub fn is_online(self) -> bool {
        matches!(self, Self::Sac | Self::Sac20 | Self::Mbpo | Self::MbpoPaper | Self::SindyMbpo)
    }
}
