//! What a report says, section by section.

mod costs;
mod findings;
mod found;
mod overview;
mod returns;
mod settings;
mod steps;
