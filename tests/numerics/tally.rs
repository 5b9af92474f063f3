//! What was tried of a kind of stress, and the worst that was seen: a row of the table in `docs/numerics.md`.
#![allow(dead_code)] // Each program uses its own share.

/// The head of the table.
pub const HEAD: &str = "| kind | cases | triangles | samples | position, px | cut, px | sample nearer, ulp | farther, ulp | stored nearer, ulp | owners | hidden | false culls |";

#[derive(Default)]
pub struct Tally {
    pub cases: u64,
    /// Triangles drawn, as clipping left them.
    pub triangles: u64,
    /// Of these, with a depth that is not known closely.
    pub slivers: u64,
    /// Triangles at samples, each compared.
    pub samples: u64,
    /// Triangles for which the bound on positions says nothing: a corner all but in the eye's plane.
    pub unbounded: u64,
    /// How far a vertex is drawn from its exact projection, in pixels; of triangles that no plane cuts.
    pub position: f64,
    /// The same of those that one cuts.
    pub cut: f64,
    /// How much nearer than the true surface a triangle's depth is at a sample, in f32 steps.
    pub nearer: f64,
    /// How much farther; not of slivers, which have their farthest depth all over.
    pub farther: f64,
    /// How much nearer than the true nearest surface a depth is that occluders left in a tile.
    pub stored_nearer: f64,
    /// Things that own a pixel, times the questions asked about each.
    pub owners: u64,
    /// Questions answered "hidden".
    pub hidden: u64,
    /// Questions answered "hidden" about a thing that owns a pixel.
    pub false_culls: u64,
    /// The first of these.
    pub first_false_cull: Option<String>,
}

pub fn keep_largest(worst: &mut f64, value: f64) {
    if value > *worst {
        *worst = value;
    }
}

impl Tally {
    pub fn row(&self, kind: &str) -> String {
        format!(
            "| {kind} | {} | {} | {} | {:.6} | {:.6} | {:.3} | {:.3} | {:.3} | {} | {} | {} |",
            self.cases,
            self.triangles,
            self.samples,
            self.position,
            self.cut,
            self.nearer,
            self.farther,
            self.stored_nearer,
            self.owners,
            self.hidden,
            self.false_culls
        )
    }

    /// Counts an answer about a thing, which is wrong if it says that an owner of a pixel is hidden.
    pub fn answer(&mut self, owns: bool, hidden: bool, said: impl FnOnce() -> String) {
        self.owners += u64::from(owns);
        self.hidden += u64::from(hidden);
        if owns && hidden {
            self.false_culls += 1;
            self.first_false_cull.get_or_insert_with(said);
        }
    }
}
