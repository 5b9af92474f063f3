//! Selections by what could be seen in the last frame: GW §5.2 takes what was visible, HOM §7.4 also what has entered the frustum.
//!
//! With the objects F in the frustum and the visible ones V of the last frame, and F′ of this one, equation 7.1 takes
//! C = (F′ − F) ∪ (F′ ∩ V). (Its second line, as printed, lacks the parentheses.)

use super::Selection;

/// What the last frame had in its frustum, and what it saw.
#[derive(Clone, Debug, Default)]
pub struct LastFrame {
    in_frustum: Vec<u32>,
    visible: Vec<u32>,
}

impl LastFrame {
    /// Forgets it.
    pub fn clear(&mut self) {
        self.in_frustum.clear();
        self.visible.clear();
    }

    /// Whether an object that is in the frustum may be an occluder.
    pub fn is_candidate(&self, selection: Selection, object: u32) -> bool {
        let was_visible = || self.visible.binary_search(&object).is_ok();
        match selection {
            Selection::PreviousVisible => was_visible(),
            Selection::Coherent => self.in_frustum.binary_search(&object).is_err() || was_visible(),
            _ => true,
        }
    }

    /// Remembers a frame: the objects in its frustum, and the visible ones, both in scene order.
    pub fn remember(&mut self, in_frustum: &[u32], visible: &[u32]) {
        self.in_frustum.clear();
        self.in_frustum.extend_from_slice(in_frustum);
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
        let of = |selection| now.map(|object| last.is_candidate(selection, object));
        assert_eq!(of(Selection::Coherent), [true, false, true]);
        assert_eq!(of(Selection::PreviousVisible), [true, false, false]);
        assert_eq!(of(Selection::Nearest), [true; 3]);
    }
}
