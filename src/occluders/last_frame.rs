//! Selections by what could be seen in the last frames: GW §5.2 takes what was visible, HOM §7.4 also what has entered the frustum.
//!
//! With the objects F in the frustum and the visible ones V of the last frame, and F′ of this one, equation 7.1 takes
//! C = (F′ − F) ∪ (F′ ∩ V). (Its second line, as printed, lacks the parentheses.)

use super::Selection;

/// Which frame's visible objects are candidates, where these are what was visible (GW §5.2).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum FramesBack {
    /// The last frame's. It has to be known before this one begins.
    #[default]
    One,
    /// Those of the frame before the last. Occluders of a frame can be drawn then while the last one is still being culled.
    Two,
}

impl FramesBack {
    /// How many frames that is.
    pub fn count(self) -> u32 {
        match self {
            FramesBack::One => 1,
            FramesBack::Two => 2,
        }
    }
}

/// What the last frame had in its frustum, and what it and the one before saw.
#[derive(Clone, Debug, Default)]
pub struct LastFrame {
    in_frustum: Vec<u32>,
    visible: Vec<u32>,
    visible_before: Vec<u32>,
}

impl LastFrame {
    /// Forgets it.
    pub fn clear(&mut self) {
        self.in_frustum.clear();
        self.visible.clear();
        self.visible_before.clear();
    }

    /// Whether an object that is in the frustum may be an occluder. Equation 7.1 is about two frames in succession, whatever
    /// `back` says.
    pub fn is_candidate(&self, selection: Selection, back: FramesBack, object: u32) -> bool {
        let was_visible = |visible: &[u32]| visible.binary_search(&object).is_ok();
        match (selection, back) {
            (Selection::PreviousVisible, FramesBack::One) => was_visible(&self.visible),
            (Selection::PreviousVisible, FramesBack::Two) => was_visible(&self.visible_before),
            (Selection::Coherent, _) => {
                self.in_frustum.binary_search(&object).is_err() || was_visible(&self.visible)
            }
            _ => true,
        }
    }

    /// Remembers a frame: the objects in its frustum, and the visible ones, both in scene order.
    pub fn remember(&mut self, in_frustum: &[u32], visible: &[u32]) {
        self.in_frustum.clear();
        self.in_frustum.extend_from_slice(in_frustum);
        std::mem::swap(&mut self.visible, &mut self.visible_before);
        self.visible.clear();
        self.visible.extend_from_slice(visible);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn candidates_are_what_equation_7_1_says() {
        let mut last = LastFrame::default();
        // Objects 1 to 4 were in the frustum, 2 and 3 were visible.
        last.remember(&[1, 2, 3, 4], &[2, 3]);
        let now = [2, 4, 5];
        let of =
            |selection| now.map(|object| last.is_candidate(selection, FramesBack::One, object));
        assert_eq!(of(Selection::Coherent), [true, false, true]);
        assert_eq!(of(Selection::PreviousVisible), [true, false, false]);
        assert_eq!(of(Selection::Nearest), [true; 3]);
    }

    #[test]
    fn two_frames_back_is_what_was_visible_before_the_last() {
        let mut last = LastFrame::default();
        let candidates = |last: &LastFrame, selection| {
            let objects = 0..5;
            let is_candidate =
                |&object: &u32| last.is_candidate(selection, FramesBack::Two, object);
            objects.filter(is_candidate).collect::<Vec<u32>>()
        };
        last.remember(&[1, 2, 3, 4], &[2, 3]);
        // There was no frame before.
        assert!(candidates(&last, Selection::PreviousVisible).is_empty());
        last.remember(&[0, 1, 2, 3, 4], &[3, 4]);
        assert_eq!(candidates(&last, Selection::PreviousVisible), [2, 3]);
        last.remember(&[0, 1], &[1]);
        assert_eq!(candidates(&last, Selection::PreviousVisible), [3, 4]);
        // Equation 7.1 takes what has entered the frustum, and what was visible in the last frame.
        assert_eq!(candidates(&last, Selection::Coherent), [1, 2, 3, 4]);
        last.clear();
        assert!(candidates(&last, Selection::PreviousVisible).is_empty());
    }
}
