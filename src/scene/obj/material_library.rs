//! Material libraries: which materials let light through, and their colours.
//!
//! Five statements matter, and tobj's reader panics on one of them (a colour of fewer than three numbers), so they are
//! read here. A library that is missing is a warning: the geometry is there without it.
//!
//! Source: *MTL material format*, Alias|Wavefront 1995.

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};

use super::Result;
use super::clean::PLAIN;
use crate::scene::load_budget::LoadBudget;
use crate::scene::warnings::Warnings;
use crate::scene::{Alpha, Material, read_file};

/// The materials read so far.
#[derive(Default)]
pub(super) struct Library {
    pub materials: HashMap<String, Material>,
    /// Libraries that have been read, or have been missed: a file may name one a million times.
    known: HashSet<PathBuf>,
}

/// The largest library that is read: far above any sound one.
const LARGEST: u64 = 64 << 20;
/// Bytes a material, or a library's path, takes beside its name.
const ENTRY_BYTES: u64 = 128;

impl Library {
    /// Reads what an `mtllib` statement names: one file whose name may hold spaces, or several without.
    pub(super) fn read(
        &mut self,
        names: &str,
        folder: &Path,
        budget: &LoadBudget,
        warnings: &mut Warnings,
        place: &str,
    ) -> Result<()> {
        let whole = [names];
        let each: Vec<&str> = names.split_whitespace().collect();
        for &name in if folder.join(names).is_file() {
            &whole[..]
        } else {
            &each[..]
        } {
            let relative = Path::new(name);
            if relative.is_absolute() || relative.has_root() {
                warnings.note(
                    "the material library is not relative to the scene and is left out",
                    format_args!("{place}, {name:?}"),
                );
                continue;
            }
            let path = folder.join(relative);
            let path = std::fs::canonicalize(&path).unwrap_or(path);
            if self.known.contains(&path) {
                continue;
            }
            budget.reserve(
                ENTRY_BYTES + path.as_os_str().len() as u64,
                "a material library",
            )?;
            self.known.insert(path.clone());
            let size = std::fs::metadata(&path).map_or(0, |m| m.len()).min(LARGEST);
            let Ok(bytes) = read_file(&path, size) else {
                warnings.note(
                    "the material library cannot be read; its surfaces are white and opaque",
                    format_args!("{place}, {name:?}"),
                );
                continue;
            };
            budget.has_read(size);
            budget.reserve(size, "a material library")?;
            parse(&bytes, budget, &mut self.materials, warnings, name)?;
            budget.release(size);
        }
        Ok(())
    }
}

fn parse(
    bytes: &[u8],
    budget: &LoadBudget,
    materials: &mut HashMap<String, Material>,
    warnings: &mut Warnings,
    file: &str,
) -> Result<()> {
    let mut current: Option<(String, Material)> = None;
    for (number, line) in (1..).zip(bytes.split(|&b| b == b'\n')) {
        let line = String::from_utf8_lossy(line);
        let line = line.trim();
        let (keyword, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        if keyword == "newmtl" {
            materials.extend(current.take());
            budget.reserve(ENTRY_BYTES + rest.len() as u64, "a material")?;
            current = Some((rest.trim().to_owned(), PLAIN));
            continue;
        }
        let Some((_, material)) = &mut current else {
            continue;
        };
        if !set(material, keyword, rest) {
            warnings.note(
                "the statement cannot be read and is left out",
                format_args!("{file:?} line {number}"),
            );
        }
    }
    materials.extend(current);
    Ok(())
}

/// Applies one statement; says whether it made sense.
fn set(material: &mut Material, keyword: &str, rest: &str) -> bool {
    let numbers: Vec<f32> = match keyword {
        "Kd" | "d" | "Tr" => rest
            .split_whitespace()
            .filter(|w| *w != "-halo")
            .map_while(|w| w.parse().ok())
            .collect(),
        "map_d" => {
            // A translucent material stays that: neither occludes.
            if material.alpha == Alpha::Opaque {
                material.alpha = Alpha::Mask;
            }
            return true;
        }
        _ => return true,
    };
    let in_range = |n: &f32| n.clamp(0.0, 1.0);
    match (keyword, numbers.as_slice()) {
        _ if numbers.iter().any(|n| n.is_nan()) => return false,
        ("Kd", [r, g, b, ..]) => material.color[..3].copy_from_slice(&[r, g, b].map(in_range)),
        // One number stands for three.
        ("Kd", [grey]) => material.color[..3].fill(in_range(grey)),
        ("d", [opacity, ..]) => dissolve(material, in_range(opacity)),
        ("Tr", [transparency, ..]) => dissolve(material, 1.0 - in_range(transparency)),
        // A spectral curve or CIE XYZ: a colour that is not read.
        ("Kd", []) if rest.starts_with("spectral") || rest.starts_with("xyz") => {}
        _ => return false,
    }
    true
}

fn dissolve(material: &mut Material, opacity: f32) {
    material.color[3] = opacity;
    if opacity < 1.0 {
        material.alpha = Alpha::Blend;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn after(statements: &[(&str, &str)]) -> Material {
        statements
            .iter()
            .fold(PLAIN, |mut material, (keyword, rest)| {
                assert!(set(&mut material, keyword, rest), "{keyword} {rest}");
                material
            })
    }

    #[test]
    fn a_material_that_lets_light_through_is_no_occluder() {
        assert_eq!(after(&[("Ka", "1 1 1")]).alpha, Alpha::Opaque);
        assert_eq!(after(&[("d", "1.0")]).alpha, Alpha::Opaque);
        assert_eq!(after(&[("d", "-halo 0.5")]).alpha, Alpha::Blend);
        assert_eq!(after(&[("Tr", "0.25")]).color[3], 0.75);
        assert_eq!(after(&[("map_d", "leaf.png")]).alpha, Alpha::Mask);
        assert_eq!(
            after(&[("d", "0.5"), ("map_d", "leaf.png")]).alpha,
            Alpha::Blend
        );
    }

    #[test]
    fn nonsense_is_noticed_and_changes_nothing() {
        for (keyword, rest) in [
            ("Kd", "red"),
            ("Kd", "1 1"),
            ("Kd", "nan nan nan"),
            ("d", ""),
            ("Tr", "x"),
        ] {
            let mut material = PLAIN;
            assert!(!set(&mut material, keyword, rest), "{keyword} {rest}");
            assert_eq!(material, PLAIN);
        }
    }
}
