//! Equations of machines that are disturbed: rubbed, touched, pushed by what nobody measured.
//!
//! What such a machine does is not its equations and sensor noise: along a whole recording no equations follow it. Over pieces of a fraction of a second they
//! do, except where something disturbed it. So rows are those of the weak form over windows, equations are fitted to pieces that begin anew, each piece has
//! a robust weight, and terms are chosen by how well pieces are predicted that were left out.

mod account;
mod cut;
mod fit;
mod grouped;
mod linearised;
mod search;
mod weak;

pub(crate) use account::Disturbed;
pub(crate) use search::Cut;
