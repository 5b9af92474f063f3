//! How the depth of occluders is represented, and what goes with what.

use std::num::NonZeroU32;

use antumbra::cull::Settings;
use antumbra::occlusion::{Accuracy, DepthRepresentation, MOST_NTH};
use antumbra::view::MapScale;
use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};

use super::failure::Failure;

/// What is kept of the depth of occluders.
#[derive(Clone, Copy, Debug, Args)]
pub struct DepthOptions {
    /// How depth is represented. All but no-background draw occluders first and ask after, so by contribution the nearest
    /// are drawn, and go with --map-scale 1 alone
    #[arg(long, value_name = "REPRESENTATION", default_value = "no-background", value_parser = representations())]
    pub depth: DepthRepresentation,

    /// With hierarchical depth and approximate accuracy: the N-th farthest value stands for a cell, and N - 1 samples are
    /// ignored in each
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=i64::from(MOST_NTH)))]
    pub nth: u32,
}

impl DepthOptions {
    /// These settings, with depth so represented.
    ///
    /// # Errors
    /// If the options do not go together.
    pub fn of(self, settings: Settings) -> Result<Settings, Failure> {
        let refuse = |why: &str| Err(Failure::Usage(why.to_owned()));
        let is_default = self.depth == DepthRepresentation::NoBackground;
        if !is_default && settings.map_scale != MapScale::Full {
            return refuse(
                "--depth: only no-background goes with a map coarser than the picture; add --map-scale 1",
            );
        }
        if !is_default && !settings.slack.is_none() {
            return refuse(
                "--depth: only no-background keeps away from what another final pass may do; leave --slack out",
            );
        }
        let depth = match (self.depth, NonZeroU32::new(self.nth)) {
            (DepthRepresentation::Hierarchical { .. }, Some(nth)) => {
                DepthRepresentation::Hierarchical { nth }
            }
            (_, Some(nth)) if nth.get() > 1 => {
                return refuse("--nth: only hierarchical depth has it; add --depth hierarchical");
            }
            (depth, _) => depth,
        };
        if depth.nth() > 1 && settings.accuracy == Accuracy::Exact {
            return refuse("--nth: more than 1 ignores samples; add --accuracy approximate");
        }
        Ok(Settings { depth, ..settings })
    }
}

/// Reads the name of a representation.
fn representations() -> impl TypedValueParser<Value = DepthRepresentation> {
    let names = DepthRepresentation::ALL.map(DepthRepresentation::name);
    PossibleValuesParser::new(names).try_map(|name| name.parse::<DepthRepresentation>())
}
