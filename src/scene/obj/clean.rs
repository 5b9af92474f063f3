//! The text as tobj is to see it.
//!
//! **Invariant.** The cleaned text is made of three statements alone, with indices in range and numbers finite:
//!
//! ```text
//! v x y z        all of them first, so that a face may come before its vertices
//! o RUN          a run of faces that share object and material, by its number
//! f i j k …      three or more, absolute, positions only
//! ```
//!
//! Source: *Object Files (.obj)*, Wavefront Advanced Visualizer, appendix B1.

use std::borrow::Cow;
use std::io::Write;
use std::path::Path;

use super::Result;
use super::material_library::Library;
use crate::scene::Material;
use crate::scene::error::Fault;
use crate::scene::load_budget::{LoadBudget, OBJECT_BYTES};
use crate::scene::warnings::Warnings;

/// A cleaned file.
pub(super) struct Clean {
    pub text: Vec<u8>,
    pub runs: Vec<Run>,
    /// The names of the objects that have faces.
    pub objects: Vec<String>,
}

/// Consecutive faces of one object and one material.
#[derive(Clone, Copy)]
pub(super) struct Run {
    pub object: usize,
    pub material: Material,
}

/// Bytes that tobj and the mesh take for a vertex: its position three times, and a place in a hash map.
const VERTEX_BYTES: u64 = 88;
/// Bytes that tobj takes for a face of up to four corners.
const FACE_BYTES: u64 = 112;
/// Bytes that tobj takes for each corner of a larger face, in a list that grows by doubling.
const CORNER_BYTES: u64 = 48;
/// Bytes for each triangle, in tobj's mesh and in ours.
const TRIANGLE_BYTES: u64 = 24;
/// Bytes of a tobj model.
const RUN_BYTES: u64 = 640;

/// What surfaces look like that name no material.
pub(super) const PLAIN: Material = Material {
    alpha: crate::scene::Alpha::Opaque,
    double_sided: true,
    color: [1.0; 4],
};

struct Cleaner<'a> {
    budget: &'a LoadBudget,
    warnings: &'a mut Warnings,
    vertices: Vec<u8>,
    vertex_count: usize,
    faces: Vec<u8>,
    /// Indices of the face at hand.
    corners: Vec<usize>,
    /// The highest index of all that was beyond the vertices so far, its line and its object.
    highest: (usize, usize, usize),
    object_name: String,
    group_name: String,
    object_begins: bool,
    material: Material,
    runs: Vec<Run>,
    objects: Vec<String>,
    library: Library,
}

/// Cleans a file; the line at fault is named if it cannot be.
pub(super) fn clean(
    bytes: &[u8],
    folder: &Path,
    budget: &LoadBudget,
    warnings: &mut Warnings,
) -> Result<Clean> {
    let mut cleaner = Cleaner {
        budget,
        warnings,
        vertices: Vec::new(),
        vertex_count: 0,
        faces: Vec::new(),
        corners: Vec::new(),
        highest: (0, 0, 0),
        object_name: String::new(),
        group_name: String::new(),
        object_begins: true,
        material: PLAIN,
        runs: Vec::new(),
        objects: Vec::new(),
        library: Library::default(),
    };
    for (number, line) in logical_lines(bytes) {
        cleaner
            .statement(&line, number, folder)
            .map_err(|fault| match cleaner.name() {
                name if name.is_empty() => fault.within(format_args!("line {number}")),
                name => fault.within(format_args!("line {number}, object {name:?}")),
            })?;
    }
    if cleaner.highest.0 > cleaner.vertex_count {
        let (index, line, object) = cleaner.highest;
        return Err(Fault::damaged(
            format_args!("line {line}, object {:?}", cleaner.objects[object]),
            format!(
                "index out of range: vertex {index}, but the file has {}",
                cleaner.vertex_count
            ),
        ));
    }
    let mut text = cleaner.vertices;
    text.append(&mut cleaner.faces);
    Ok(Clean {
        text,
        runs: cleaner.runs,
        objects: cleaner.objects,
    })
}

/// Lines with their numbers from 1, those that end in a backslash joined to the next. Bytes that are no UTF-8 (old
/// files have names in other encodings) become replacement characters.
fn logical_lines(bytes: &[u8]) -> impl Iterator<Item = (usize, Cow<'_, str>)> {
    let mut physical = (1..).zip(bytes.split(|&b| b == b'\n'));
    std::iter::from_fn(move || {
        let (number, first) = physical.next()?;
        let continued = |line: &[u8]| line.trim_ascii_end().ends_with(b"\\");
        if !continued(first) {
            return Some((number, String::from_utf8_lossy(first)));
        }
        let mut joined = Vec::new();
        let mut next = Some(first);
        while let Some(line) = next {
            let more = continued(line);
            joined.extend_from_slice(line.trim_ascii_end().strip_suffix(b"\\").unwrap_or(line));
            joined.push(b' ');
            next = if more {
                physical.next().map(|(_, line)| line)
            } else {
                None
            };
        }
        Some((number, String::from_utf8_lossy(&joined).into_owned().into()))
    })
}

impl Cleaner<'_> {
    /// The object that a face would now belong to.
    fn name(&self) -> String {
        match (self.object_name.as_str(), self.group_name.as_str()) {
            (object, "") => object.to_owned(),
            ("", group) => group.to_owned(),
            (object, group) if object == group => object.to_owned(),
            (object, group) => format!("{object}/{group}"),
        }
    }

    fn statement(&mut self, line: &str, number: usize, folder: &Path) -> Result<()> {
        let line = line.trim();
        let (keyword, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        let rest = rest.trim();
        match keyword {
            "" => {}
            _ if keyword.starts_with('#') => {}
            // Names may hold a hash mark; numbers cannot.
            "v" => self.vertex(rest.split('#').next().unwrap_or(""))?,
            "f" => self.face(rest.split('#').next().unwrap_or(""), number)?,
            "o" if rest != self.object_name || !self.group_name.is_empty() => {
                self.object_name = rest.to_owned();
                self.group_name.clear();
                self.object_begins = true;
            }
            "g" if rest != self.group_name => {
                self.group_name = rest.to_owned();
                self.object_begins = true;
            }
            "usemtl" => self.use_material(rest, number),
            "mtllib" => {
                let place = format!("line {number}");
                self.library
                    .read(rest, folder, self.budget, self.warnings, &place)?;
            }
            "l" | "p" => {
                self.warnings.note(
                    "it draws points or lines, which are left out",
                    format_args!("line {number}"),
                );
            }
            "o" | "g" | "vt" | "vn" | "s" | "mg" | "usemap" | "maplib" | "shadow_obj"
            | "trace_obj" | "lod" | "bevel" | "c_interp" | "d_interp" => {}
            "vp" | "cstype" | "deg" | "bmat" | "step" | "curv" | "curv2" | "surf" | "parm"
            | "trim" | "hole" | "scrv" | "sp" | "end" | "con" | "ctech" | "stech" | "bzp"
            | "bsp" => {
                self.warnings.note(
                    "free-form curves and surfaces are left out",
                    format_args!("line {number}"),
                );
            }
            _ => self.warnings.note(
                "a statement that is not understood is left out",
                format_args!("line {number}"),
            ),
        }
        Ok(())
    }

    fn vertex(&mut self, rest: &str) -> Result<()> {
        let index = self.vertex_count + 1;
        let damaged = |cause: String| Fault::damaged(format_args!("vertex {index}"), cause);
        let mut position = [0.0f32; 3];
        let mut words = rest.split_whitespace();
        for (axis, coordinate) in ["x", "y", "z"].into_iter().zip(&mut position) {
            let Some(word) = words.next() else {
                return Err(damaged(format!("it has no {axis}")));
            };
            *coordinate = number(word).map_err(damaged)?;
        }
        // A fourth number alone is a weight; more are a colour.
        if let (Some(weight), None) = (words.next(), words.next()) {
            let weight = number(weight).map_err(damaged)?;
            position = position.map(|c| c / weight);
            if !position.iter().all(|c| c.is_finite()) {
                return Err(damaged(format!(
                    "divided by its weight {weight} it is not finite"
                )));
            }
        }
        self.vertex_count += 1;
        let start = self.vertices.len();
        let [x, y, z] = position;
        // The shortest text that gives the same f32 again.
        let _ = writeln!(self.vertices, "v {x} {y} {z}");
        self.budget.reserve(
            VERTEX_BYTES + (self.vertices.len() - start) as u64,
            "a vertex",
        )
    }

    fn face(&mut self, rest: &str, line: usize) -> Result<()> {
        self.corners.clear();
        for word in rest.split_whitespace() {
            let corner = self.corner(word)?;
            self.corners.push(corner);
        }
        let corners = self.corners.len();
        if corners < 3 {
            self.warnings.note(
                "a face of fewer than three vertices is left out",
                format_args!("line {line}"),
            );
            return Ok(());
        }
        self.begin_run()?;
        if let Some(&highest) = self.corners.iter().max()
            && highest > self.highest.0
            && highest > self.vertex_count
        {
            self.highest = (highest, line, self.objects.len() - 1);
        }
        let start = self.faces.len();
        self.faces.push(b'f');
        for corner in &self.corners {
            let _ = write!(self.faces, " {corner}");
        }
        self.faces.push(b'\n');
        let listed = if corners > 4 {
            corners as u64 * CORNER_BYTES
        } else {
            0
        };
        let bytes = FACE_BYTES
            + listed
            + (corners - 2) as u64 * TRIANGLE_BYTES
            + (self.faces.len() - start) as u64;
        self.budget.reserve(bytes, "a face")
    }

    /// The vertex of `v`, `v/vt`, `v//vn` or `v/vt/vn`, counted from 1.
    fn corner(&self, word: &str) -> Result<usize> {
        let damaged = |cause: String| Fault::damaged("a face", cause);
        let mut parts = word.split('/').map(|part| {
            if part.is_empty() {
                Ok(None)
            } else {
                part.parse().map(Some)
            }
        });
        let first: Option<i64> = parts.next().and_then(|p| p.ok()).flatten();
        if parts.clone().count() > 2 || parts.any(|p| p.is_err()) {
            return Err(damaged(format!(
                "{word:?} is no vertex: v, v/vt, v//vn or v/vt/vn is"
            )));
        }
        let vertex = match first {
            None => {
                return Err(damaged(format!(
                    "{word:?} is no vertex: v, v/vt, v//vn or v/vt/vn is"
                )));
            }
            Some(0) => {
                return Err(damaged(
                    "index out of range: there is no vertex 0, the first is 1".to_owned(),
                ));
            }
            Some(v) if v > 0 => usize::try_from(v).ok(),
            Some(v) => usize::try_from(v.unsigned_abs())
                .ok()
                .and_then(|back| (self.vertex_count + 1).checked_sub(back)),
        };
        vertex.filter(|&v| v > 0).ok_or_else(|| {
            damaged(format!(
                "index out of range: {word:?}, but there are {} vertices so far",
                self.vertex_count
            ))
        })
    }

    fn begin_run(&mut self) -> Result<()> {
        if self.object_begins {
            let name = match self.name() {
                name if name.is_empty() => format!("object {}", self.objects.len()),
                name => name,
            };
            self.budget
                .reserve(OBJECT_BYTES + 2 * name.len() as u64, "an object")?;
            self.objects.push(name);
            self.object_begins = false;
        }
        let run = Run {
            object: self.objects.len() - 1,
            material: self.material,
        };
        if self
            .runs
            .last()
            .is_none_or(|last| last.object != run.object || last.material != run.material)
        {
            self.budget.reserve(RUN_BYTES, "a change of material")?;
            let _ = writeln!(self.faces, "o {}", self.runs.len());
            self.runs.push(run);
        }
        Ok(())
    }

    fn use_material(&mut self, name: &str, line: usize) {
        self.material = match self.library.materials.get(name) {
            Some(&material) => material,
            None => {
                self.warnings.note(
                    "the material is in no library that was read; its surfaces are white and opaque",
                    format_args!("line {line}, material {name:?}"),
                );
                PLAIN
            }
        };
    }
}

/// A finite number.
fn number(word: &str) -> std::result::Result<f32, String> {
    match word.parse::<f32>() {
        Ok(number) if number.is_finite() => Ok(number),
        Ok(_) => Err(format!("its position is not finite: {word}")),
        Err(_) => Err(format!("{word:?} is not a number")),
    }
}
