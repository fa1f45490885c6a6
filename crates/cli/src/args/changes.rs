//! Values in place of the model's: `--set`, and the load case of `--case`.

use std::ops::Deref;

use bksim::model::file::CASE;
use clap::{ArgMatches, Args, Command, Error, FromArgMatches};

use super::assignment;

/// Values of `--set`, with the load case of `--case` ahead of them.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Changes(pub Vec<(String, String)>);

/// The options as they are written.
#[derive(Args)]
struct Written {
    /// Give a parameter another value: a number, a quantity such as "25 mm", or an expression.
    #[arg(long = "set", value_name = "NAME=VALUE", value_parser = assignment)]
    set: Vec<(String, String)>,
    /// Take this load case of the model's `[cases]`; values of --set go over it.
    #[arg(long, value_name = "NAME")]
    case: Option<String>,
    /// Do it for each of the model's `[cases]`; the name of a file gets that of the case.
    #[arg(long = "cases", conflicts_with = "case")]
    every_case: bool,
}

impl Deref for Changes {
    type Target = Vec<(String, String)>;

    fn deref(&self) -> &Self::Target {
        &self.0
    }
}

impl Changes {
    /// The changes of a case, then these.
    #[must_use]
    pub fn of_case(&self, name: &str) -> Self {
        let case = std::iter::once((CASE.to_owned(), name.to_owned()));
        Self(case.chain(self.0.iter().cloned()).collect())
    }

    /// The load case that is chosen.
    pub fn case(&self) -> Option<&str> {
        self.0.iter().find(|(name, _)| name == CASE).map(|(_, case)| case.as_str())
    }
}

impl FromArgMatches for Changes {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, Error> {
        let Written { set, case, .. } = Written::from_arg_matches(matches)?;
        let changes = Self(set);
        Ok(case.map_or_else(|| changes.clone(), |case| changes.of_case(&case)))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

impl Args for Changes {
    fn augment_args(command: Command) -> Command {
        Written::augment_args(command)
    }

    fn augment_args_for_update(command: Command) -> Command {
        Written::augment_args(command)
    }
}
