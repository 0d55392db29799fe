//! What a report says, section by section.

mod costs;
mod found;
mod overview;
mod returns;
mod steps;
