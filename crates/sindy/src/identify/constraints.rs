//! What a user knows of the equations before they are looked for.

use sindyna_core::FitError;

use super::Identifier;
use super::known::{EquationConstraint, EquationConstraintError};
use crate::estimate::Constraints;
use crate::expr::{ParseError, parse};
use crate::library::{Term, complexity};
use crate::{Expr, Role};

impl Identifier {
    /// The same with something known of the equation of the state `state`. Constraints are for equations of motion found by
    /// best subsets, the default; identification refuses them elsewhere.
    ///
    /// # Errors
    /// [`EquationConstraintError`] if there is no such state, its rate is declared, or the formula cannot be read.
    ///
    /// # Examples
    /// ```
    /// use sindyna_sindy::{EquationConstraint, Identifier, Signals};
    ///
    /// let pendulum = Signals::new(&["th", "w"], &["u"]).angle("th")?.rate("w", "th")?;
    /// let identifier = Identifier::of_signals(&pendulum, 0.05)?
    ///     .with_constraint("w", EquationConstraint::Known("-9.81*sin(th)".into()))?
    ///     .with_constraint("w", EquationConstraint::Negative("w".into()))?;
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn with_constraint(
        mut self,
        state: &str,
        constraint: EquationConstraint,
    ) -> Result<Self, EquationConstraintError> {
        let names: Vec<&str> = self.spec.state.iter().map(|s| s.name.as_str()).collect();
        let Some(i) = names.iter().position(|name| *name == state) else {
            return Err(EquationConstraintError::NoSuchState { name: state.into(), known: names.join(", ") });
        };
        if let Some(rate) = self.rates()[i] {
            return Err(EquationConstraintError::Kinematic { state: state.into(), rate: names[rate].into() });
        }
        let summands = self.formula(&constraint)?.summands();
        let one = matches!(&summands[..], [(c, _)] if c.to_bits() == 1_f64.to_bits());
        if !one && !matches!(constraint, EquationConstraint::Known(_)) {
            return Err(EquationConstraintError::NotOneTerm { formula: constraint.formula().into() });
        }
        self.constraints.push((i, constraint));
        self.check_contradictions()?;
        Ok(self)
    }

    fn check_contradictions(&self) -> Result<(), EquationConstraintError> {
        let mut terms = Vec::new();
        let rows = self.constrained(&mut terms)?;
        for (row, state) in rows.iter().zip(&self.spec.state) {
            let there = row.required.iter().chain(row.fixed.iter().map(|(j, _)| j));
            if let Some(&j) = there.into_iter().find(|j| row.forbidden.contains(j)) {
                let (formula, state) = (terms[j].name.clone(), state.name.clone());
                return Err(EquationConstraintError::Contradiction { formula, state });
            }
        }
        Ok(())
    }

    /// Refuses constraints where they would be ignored.
    pub(super) fn refuse_constraints(&self) -> Result<(), FitError> {
        if self.constraints.is_empty() {
            return Ok(());
        }
        let reason = "known, required, forbidden and signed terms need the target `motion` with best subsets in recognised coordinates";
        Err(FitError::Regression { reason: reason.into() })
    }

    fn formula(&self, constraint: &EquationConstraint) -> Result<Expr, ParseError> {
        let names: Vec<String> = self.inputs().into_iter().map(|input| input.name).collect();
        parse(constraint.formula(), &names)
    }

    /// The constraints on each equation over `terms`, which get those that are not there yet.
    pub(super) fn constrained(&self, terms: &mut Vec<Term>) -> Result<Vec<Constraints>, ParseError> {
        if self.constraints.is_empty() {
            return Ok(Vec::new());
        }
        let inputs = self.inputs();
        let roles: Vec<Role> = inputs.iter().map(|i| i.role).collect();
        let names: Vec<String> = inputs.into_iter().map(|i| i.name).collect();
        let mut number = |expr: Expr| {
            let known = terms.iter().position(|t| t.rate.is_none() && same(&t.expr, &expr, names.len()));
            known.unwrap_or_else(|| {
                let (name, complexity) = (expr.display(&names).to_string(), complexity(&expr, &roles));
                terms.push(Term { expr, name, complexity, rate: None, shape: None });
                terms.len() - 1
            })
        };
        let mut rows = vec![Constraints::default(); self.spec.state_dim()];
        for (i, constraint) in &self.constraints {
            let row = &mut rows[*i];
            for (c, term) in self.formula(constraint)?.summands() {
                let j = number(term);
                match constraint {
                    EquationConstraint::Known(_) => row.fixed.push((j, c)),
                    EquationConstraint::Required(_) => row.required.push(j),
                    EquationConstraint::Forbidden(_) => row.forbidden.push(j),
                    EquationConstraint::Positive(_) => row.signs.push((j, 1.0)),
                    EquationConstraint::Negative(_) => row.signs.push((j, -1.0)),
                }
            }
            row.required.sort_unstable();
            row.required.dedup();
        }
        Ok(rows)
    }
}

/// Whether two terms have the same values, at a few places.
fn same(a: &Expr, b: &Expr, n_variables: usize) -> bool {
    let place = |at: usize| -> Vec<f64> {
        (0..n_variables).map(|i| 0.3 + (1.7 * (i + 1) as f64 + 0.9 * at as f64).sin()).collect()
    };
    (0..4).all(|at| {
        let (a, b) = (a.eval(&place(at)), b.eval(&place(at)));
        (a - b).abs() <= 1e-12 * a.abs() || a.is_nan() && b.is_nan()
    })
}
