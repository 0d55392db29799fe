//! ONNX: equations and policies as graphs of operators, for ONNX Runtime and others.
//!
//! A file for each, as a runtime wants all inputs of a graph whichever output it is asked for. Numbers are double precision on both sides, as in
//! every other language, so that what one gives the other takes.

mod equations;
mod friction;
mod graph;
mod policy;
mod proto;

pub(crate) use equations::write as equations;
pub(crate) use policy::write as policy;
