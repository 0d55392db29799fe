//! Variants of a method: the same with other settings, under a name.

use std::str::FromStr;
use std::sync::Arc;

use sindyna_record::comparison::{is_variant, variant};
use sindyna_training::Error;
use sindyna_training::settings::TrainConfig;

use super::Method;

/// `sindy` with other settings.
#[derive(Debug, Clone, PartialEq)]
pub struct Variant {
    name: String,
    /// `KEY=VALUE` each, as `--set` takes them.
    settings: Vec<String>,
}

/// A method, or a variant of one.
#[derive(Debug, Clone, PartialEq)]
pub struct Contender {
    /// The method.
    pub method: Method,
    variant: Option<Arc<Variant>>,
}

impl FromStr for Variant {
    type Err = String;

    /// Reads `NAME: KEY=VALUE,KEY=VALUE`.
    fn from_str(text: &str) -> Result<Self, String> {
        let form = "a variant is `NAME: KEY=VALUE,KEY=VALUE`, such as `stlsq: solver=stlsq,threshold=0.1`";
        let (name, settings) = text.split_once(':').ok_or(form)?;
        let name = name.trim();
        if !is_variant(name) {
            return Err(format!("the name of a variant has letters, digits, `-` and `_`, got `{name}`"));
        }
        let settings: Vec<String> = apart(settings).into_iter().filter(|part| !part.is_empty()).collect();
        if settings.is_empty() { Err(form.into()) } else { Ok(Self { name: name.into(), settings }) }
    }
}

/// The parts of `text` between commas that stand in no brackets and no quotes.
fn apart(text: &str) -> Vec<String> {
    let (mut parts, mut depth, mut quote) = (vec![String::new()], 0_usize, None);
    for c in text.chars() {
        match (c, quote) {
            ('"' | '\'', None) => quote = Some(c),
            (_, Some(open)) if c == open => quote = None,
            ('[', None) => depth += 1,
            (']', None) => depth = depth.saturating_sub(1),
            _ => {}
        }
        match parts.last_mut() {
            Some(last) if c != ',' || depth > 0 || quote.is_some() => last.push(c),
            _ => parts.push(String::new()),
        }
    }
    parts.into_iter().map(|part| part.trim().to_owned()).collect()
}

impl Contender {
    /// The variant `variant` of `sindy`.
    pub fn variant(variant: Variant) -> Self {
        Self { method: Method::Sindy, variant: Some(Arc::new(variant)) }
    }

    /// Whether it has settings of its own.
    pub fn is_variant(&self) -> bool {
        self.variant.is_some()
    }

    /// What its runs are called.
    pub fn name(&self) -> String {
        let name = self.method.name();
        self.variant.as_ref().map_or_else(|| name.to_owned(), |v| variant(name, &v.name))
    }

    /// `config` with its settings.
    pub fn settle(&self, config: TrainConfig) -> Result<TrainConfig, Error> {
        let settings = self.variant.iter().flat_map(|variant| &variant.settings);
        let config = settings.into_iter().try_fold(config, |config, text| config.with(text))?;
        config.check()?;
        Ok(config)
    }
}

impl From<Method> for Contender {
    fn from(method: Method) -> Self {
        Self { method, variant: None }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_variant_is_a_name_and_settings() {
        let variant: Variant = "small-net: hidden=[32, 32], solver=stlsq,terms=['max(x,1)']".parse().unwrap();
        assert_eq!(variant.settings, ["hidden=[32, 32]", "solver=stlsq", "terms=['max(x,1)']"]);
        let contender = Contender::variant(variant);
        assert_eq!(contender.name(), "sindy+small-net");
        for (text, says) in [
            ("stlsq", "a variant is `NAME:"),
            ("stlsq: ", "a variant is `NAME:"),
            ("../x: solver=stlsq", "letters, digits"),
            (": solver=stlsq", "letters, digits"),
        ] {
            let refusal = text.parse::<Variant>().unwrap_err();
            assert!(refusal.contains(says), "{text}: {refusal}");
        }
    }
}
