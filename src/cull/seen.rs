//! What was seen in the last frame, and is not asked about in this one.
//!
//! An object that was seen at many samples will hardly be hidden a frame later: it is taken for visible for some frames, which
//! never loses anything. And a node of the hierarchy that held such objects will hardly be hidden either, so its children are
//! asked at once. (HOM §7.4: temporal coherence.)

use super::test::{Kept, MANY};
use crate::occlusion::Footprint;
use crate::scene::{Bvh, Scene};

/// The longest that an object which shows at many samples is taken for visible, in frames. One that shows at fewer is asked again
/// after a third of that.
const LONGEST_TRUST: u32 = 24;

/// Trust is shortened when more than one in so many objects that are asked again turns out to be hidden. Half as many are kept
/// for nothing, on average.
const ONE_IN: u32 = 24;

/// What earlier frames saw.
#[derive(Clone, Debug, Default)]
pub struct Seen {
    /// For each object, the last frame in which it was visible,
    frame_of: Vec<u32>,
    /// and the last in which it is taken for visible if it was so in the one before.
    trusted_until: Vec<u32>,
    /// For each node of the hierarchy, the last frame in which something in it was not hidden.
    open_in: Vec<u32>,
    /// The number of this frame, from 2 on.
    frame: u32,
    /// For how many frames objects that show at many samples are taken for visible: less where the picture changes fast.
    trust: u32,
    /// How many objects that were visible a frame before have been asked again, and how many of them were hidden: of the last
    /// frames, each counted half as much as the next.
    asked_again: u32,
    hidden_since: u32,
    /// Whether nothing is trusted in this frame.
    is_cut: bool,
    /// The frame whose answers count: the last one, or of a part of a frame the frame itself.
    last: u32,
}

impl Seen {
    /// Forgets all.
    pub fn clear(&mut self) {
        self.frame_of.clear();
        self.trusted_until.clear();
        self.open_in.clear();
        self.trust = 0;
        self.asked_again = 0;
        self.hidden_since = 0;
    }

    /// Begins a frame.
    pub fn begin_frame(&mut self, scene: &Scene) {
        self.frame = self.frame.wrapping_add(1).max(2);
        self.is_cut = false;
        self.last = self.frame - 1;
        self.frame_of.resize(scene.objects().len(), 0);
        self.trusted_until.resize(scene.objects().len(), 0);
        self.open_in.resize(scene.bvh().nodes.len(), 0);
    }

    /// Begins a part of the frame that ended: what that saw is what was seen.
    pub fn begin_part(&mut self) {
        self.is_cut = false;
        self.last = self.frame;
    }

    /// Notes what became of the objects that a part of a frame asked about.
    pub fn note_part(&mut self, undecided: &[(u32, Footprint)], visible: &[Kept]) {
        for &(object, _) in undecided {
            self.frame_of[object as usize] = 0;
        }
        for kept in visible {
            self.frame_of[kept.object as usize] = self.frame;
        }
    }

    /// Whether an object is taken for visible without asking.
    pub fn is_trusted(&self, object: u32) -> bool {
        let object = object as usize;
        !self.is_cut
            && self.frame_of[object] == self.last
            && self.trusted_until[object] >= self.frame
    }

    /// Trusts nothing in this frame: it shows something else than the last.
    pub fn distrust(&mut self) {
        self.is_cut = true;
    }

    /// Whether something in a node was not hidden in the last frame.
    pub fn was_open(&self, node: u32) -> bool {
        self.open_in[node as usize] == self.last
    }

    /// How many of some objects are not taken for visible.
    pub fn count_in_question(&self, objects: &[(u32, Footprint)]) -> u64 {
        let in_question = objects
            .iter()
            .filter(|(object, _)| !self.is_trusted(*object));
        in_question.count() as u64
    }

    /// Notes which objects were not hidden by their boxes' rectangles, and which are visible.
    pub fn note(&mut self, bvh: &Bvh, undecided: &[(u32, Footprint)], visible: &[Kept]) {
        self.judge_trust(undecided, visible);
        let long = self.trust;
        for kept in visible {
            let object = kept.object;
            if !self.is_trusted(object) {
                let short = long / 3;
                let trust = if kept.seen >= MANY { long } else { short };
                // Not all objects are to be asked again in the same frame.
                let trust = trust + object % (trust / 2 + 1);
                self.trusted_until[object as usize] = self.frame + trust;
            }
        }
        for kept in visible {
            self.frame_of[kept.object as usize] = self.frame;
        }
        for &(object, _) in undecided {
            let mut node = bvh.leaf_of(object);
            while self.open_in[node as usize] != self.frame {
                self.open_in[node as usize] = self.frame;
                node = bvh.parent_of(node);
            }
        }
    }

    /// Finds out how long objects may be taken for visible.
    fn judge_trust(&mut self, undecided: &[(u32, Footprint)], visible: &[Kept]) {
        let was_visible = |object: u32| self.frame_of[object as usize] == self.last;
        let asked = |object: u32| was_visible(object) && !self.is_trusted(object);
        let before = undecided
            .iter()
            .filter(|(object, _)| asked(*object))
            .count() as u32;
        let still = visible.iter().filter(|kept| asked(kept.object)).count() as u32;
        self.asked_again = self.asked_again / 2 + before;
        self.hidden_since = self.hidden_since / 2 + (before - still.min(before));
        if self.hidden_since * ONE_IN > self.asked_again {
            self.trust -= self.trust.div_ceil(4);
        } else if self.asked_again > 0 {
            self.trust = LONGEST_TRUST.min(self.trust + 1);
        }
    }
}
