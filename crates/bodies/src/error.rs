//! Why bodies cannot be identified.

/// Why a file is no tree of bodies, or their parameters cannot be identified.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BodiesError {
    /// The file is no XML.
    #[error("the file is no XML")]
    Xml(#[source] roxmltree::Error),
    /// The outermost element is another.
    #[error("the outermost element is <{got}>, not <{expected}>")]
    Root {
        /// The element expected.
        expected: &'static str,
        /// The element found.
        got: String,
    },
    /// An attribute or element is missing.
    #[error("<{element}> `{name}` has no {what}")]
    Missing {
        /// The element.
        element: &'static str,
        /// Its name.
        name: String,
        /// What it should have.
        what: &'static str,
    },
    /// Text is no number, or not so many numbers.
    #[error("{what} of `{name}`: `{text}` is not {expected} finite number{}", if *expected == 1 { "" } else { "s" })]
    Number {
        /// What it is.
        what: &'static str,
        /// Name of the element it is of.
        name: String,
        /// The text.
        text: String,
        /// Numbers expected.
        expected: usize,
    },
    /// A joint that is neither hinge nor slide, or depends on another.
    #[error("the joint `{name}` is {kind}: hinges and slides are supported")]
    Joint {
        /// The joint.
        name: String,
        /// What it is.
        kind: String,
    },
    /// Something that the equations do not have.
    #[error("{what} is not supported")]
    Unsupported {
        /// What.
        what: String,
    },
    /// Links and joints are no tree.
    #[error("links and joints are no tree: {reason}")]
    NoTree {
        /// Why.
        reason: String,
    },
    /// A joint moves nothing that has a mass, or the axis is no direction.
    #[error("the axis of the joint `{name}` is no direction")]
    Axis {
        /// The joint.
        name: String,
    },
    /// There is no joint.
    #[error("no joint moves")]
    NoJoint,
    /// An array has another shape.
    #[error("{got} {what}, not {expected}")]
    Shape {
        /// What is counted.
        what: &'static str,
        /// How many there should be.
        expected: usize,
        /// How many there are.
        got: usize,
    },
    /// A value is not finite.
    #[error("a recorded value is not finite")]
    NotFinite,
    /// Times do not increase.
    #[error("the times of the samples do not increase")]
    Times,
    /// Whoever watched said so.
    #[error("interrupted")]
    Interrupted,
    /// No joint is driven.
    #[error("all forces are zero: without forces parameters are known up to a common factor only")]
    NoForce,
    /// No motion is long enough for its end to be predicted.
    #[error(
        "the last 30 % of the longest trajectory are {got} steps; at least {needed} are needed to judge parameters by"
    )]
    Short {
        /// Steps there are.
        got: usize,
        /// Steps needed.
        needed: usize,
    },
    /// There are less rows than parameters.
    #[error("{got} rows are too few for {needed} parameters")]
    TooFew {
        /// Rows there are.
        got: usize,
        /// Rows needed.
        needed: usize,
    },
}
