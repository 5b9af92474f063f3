//! Marks on a scene's objects that a frame takes off all at once: a frame must not take time for each object that exists.

/// A mark for each object, off at first.
#[derive(Clone, Debug, Default)]
pub struct Marks {
    /// When each object was marked.
    stamps: Vec<u32>,
    now: u32,
}

impl Marks {
    /// Takes all marks off; there are `objects` objects.
    pub fn clear(&mut self, objects: usize) {
        if self.now == u32::MAX {
            self.stamps.clear();
            self.now = 0;
        }
        self.now += 1;
        self.stamps.resize(objects, 0);
    }

    /// Marks an object.
    pub fn set(&mut self, object: u32) {
        self.stamps[object as usize] = self.now;
    }

    /// Whether an object is marked.
    pub fn has(&self, object: u32) -> bool {
        self.stamps[object as usize] == self.now
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_come_off_all_at_once() {
        let mut marks = Marks::default();
        marks.clear(3);
        marks.set(1);
        assert_eq!([0, 1, 2].map(|o| marks.has(o)), [false, true, false]);
        marks.clear(3);
        assert!(!marks.has(1));
        marks.now = u32::MAX;
        marks.set(2);
        marks.clear(3);
        assert_eq!([0, 1, 2].map(|o| marks.has(o)), [false; 3]);
    }
}
