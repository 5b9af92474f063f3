//! Which settings are swept over.
//!
//! The whole product of holes, scales, selections, budgets and depths is large, and most of it says nothing new. So by default two
//! slices of it are taken: every selection with every budget at the base settings, and every hole with every scale by
//! the selection and budget that the base settings name. They meet in one point, which is taken once.

use super::{ORACLE, SweepSettings};
use crate::cull::Settings;
use crate::occluders::{Budget, Selection};
use crate::occlusion::{Accuracy, Approximation, DepthRepresentation};
use crate::view::MapScale;

/// One place of the grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Place {
    /// Of its selection, or [`ORACLE`].
    pub name: &'static str,
    pub settings: Settings,
    /// Whether it differs from the base settings in the selection and the budget alone.
    pub is_base: bool,
    /// Whether it has the selection, the budget and the depth representation of the base settings.
    pub is_chosen: bool,
}

/// The places of the grid; those that differ in the selection and the budget alone come first, and of these the oracle's last.
pub(super) fn places(sweep: &SweepSettings, has_grid: bool) -> Vec<Place> {
    let base = sweep.cull;
    let choices = choices(sweep, has_grid);
    let mut places = Vec::new();
    for &(name, occluders, budget) in &choices {
        let settings = Settings {
            occluders,
            budget,
            depth: DepthRepresentation::NoBackground,
            ..base
        };
        places.push(place(sweep, name, settings, true));
    }
    let chosen = (base.occluders.name(), base.occluders, base.budget);
    let not_oracle = choices.iter().filter(|(name, ..)| *name != ORACLE);
    let of_variants: Vec<_> = if sweep.full {
        let mut all = vec![chosen];
        all.extend(not_oracle.filter(|choice| **choice != chosen));
        all
    } else {
        vec![chosen]
    };
    for depth in DepthRepresentation::ALL {
        for &(name, occluders, budget) in &of_variants {
            for &map_scale in &sweep.map_scales {
                for &hole in &sweep.holes {
                    let is_default = depth == DepthRepresentation::NoBackground;
                    // The others are for the picture's own scale, and none ignores a hole otherwise.
                    if !is_default && (map_scale != MapScale::Full || hole > 0) {
                        continue;
                    }
                    let settings = Settings {
                        accuracy: accuracy(sweep, hole),
                        map_scale,
                        occluders,
                        budget,
                        depth,
                        ..base
                    };
                    let is_new = |p: &&Place| p.name == name && p.settings == settings;
                    if places.iter().find(is_new).is_none() {
                        places.push(place(sweep, name, settings, false));
                    }
                }
            }
        }
    }
    places
}

fn place(sweep: &SweepSettings, name: &'static str, settings: Settings, is_base: bool) -> Place {
    let is_chosen = name != ORACLE
        && settings.occluders == sweep.cull.occluders
        && settings.budget == sweep.cull.budget
        && settings.depth == sweep.cull.depth;
    Place {
        name,
        settings,
        is_base,
        is_chosen,
    }
}

/// Selections with budgets, from the smallest budget to none; the oracle last.
fn choices(sweep: &SweepSettings, has_grid: bool) -> Vec<(&'static str, Selection, Budget)> {
    let budgets = || sweep.budgets.iter().copied().map(Budget::Triangles);
    let mut choices = Vec::new();
    for occluders in Selection::ALL {
        if occluders == Selection::Sampled && !has_grid {
            // It would be the nearest once more.
            continue;
        }
        let auto = (occluders == Selection::Contribution).then_some(Budget::Auto);
        for budget in budgets().chain(auto).chain([Budget::All]) {
            choices.push((occluders.name(), occluders, budget));
        }
    }
    for budget in budgets().chain([Budget::All]) {
        choices.push((ORACLE, sweep.cull.occluders, budget));
    }
    choices
}

/// Without a hole nothing is lost.
fn accuracy(sweep: &SweepSettings, hole: u32) -> Accuracy {
    match hole {
        0 => Accuracy::Exact,
        hole => Accuracy::Approximate(Approximation {
            hole,
            ..sweep.approximation
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::PictureSize;

    fn settings(full: bool) -> SweepSettings {
        SweepSettings {
            cull: Settings::new(PictureSize::new(64, 64).expect("a size")),
            budgets: vec![10, 20],
            holes: vec![0, 64],
            map_scales: MapScale::ALL.to_vec(),
            approximation: Approximation::default(),
            full,
            every: 1,
        }
    }

    #[test]
    fn two_slices_meet_in_one_point() {
        let places = places(&settings(false), false);
        // Seven selections and the oracle with two budgets and without one, and the one that chooses itself; two holes at three scales,
        // and three more representations of depth.
        assert_eq!(places.len(), (8 * 3 + 1) + (2 * 3 - 1) + 3);
        assert_eq!(places.iter().filter(|p| p.is_chosen).count(), 2 * 3);
    }

    #[test]
    fn the_full_grid_is_the_product() {
        let places = places(&settings(true), false);
        assert_eq!(places.len(), (7 * 3 + 1) * (2 * 3 + 3) + 3);
        for (i, place) in places.iter().enumerate() {
            let same = |p: &&Place| p.name == place.name && p.settings == place.settings;
            assert!(places[..i].iter().find(same).is_none(), "{place:?}");
        }
    }
}
