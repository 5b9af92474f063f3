//! The memory of contribution: what each cluster was seen to hide, so that the next frame draws the best first.
//!
//! Of the clusters that frames have drawn, the memory keeps a value each: the samples that it took over from what was drawn
//! before it, halved from frame to frame. Occluders are worth their value by what drawing them costs. The papers remember
//! which objects were visible (GW §5.2, VDR §5.3, HOM equation 7.1); what a cluster added is a stricter question, for most
//! of what can be seen hides nothing that something else does not hide.
//!
//! A cluster that adds too little is kept as such for some frames, so that it is not drawn again at once, and is then
//! forgotten. So what is remembered follows what is seen, not what exists.

use super::Budget;

/// A cluster of an object.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct ClusterId {
    /// The object.
    pub object: u32,
    /// Which of the clusters of the object's occluder.
    pub cluster: u32,
}

/// Drawing a cluster costs as much as so many triangles, besides its own.
const CLUSTER_COST: u32 = 6;

/// A budget that is chosen here spends a triangle's time for so many samples at least.
const SAMPLES_A_TRIANGLE: u32 = 8;

/// For so many frames a cluster that adds too little is not drawn again.
const REST: u8 = 24;

/// Values are kept in so many parts of a sample, so that halving does not lose them at once.
const PARTS_OF_SAMPLE: u32 = 16;

/// Of a budget of triangles, the memory takes so many quarters; what came into view takes what is left.
const QUARTERS_OF_BUDGET: u64 = 3;

/// What is remembered of a cluster.
#[derive(Clone, Copy, Debug)]
struct Known {
    id: ClusterId,
    value: u32,
    triangles: u8,
    /// For how many frames it is still remembered if nobody draws it.
    rest: u8,
    /// What was done with it in this frame.
    fate: Fate,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Fate {
    /// It was not chosen.
    Left,
    /// It was chosen, but hidden.
    Hidden,
    /// It was drawn.
    Drawn,
}

/// What clusters of instances were seen to hide.
#[derive(Clone, Debug, Default)]
pub struct Contributions {
    /// In the order of their ids.
    known: Vec<Known>,
    /// Those that this frame drew for the first time.
    new: Vec<Known>,
    merged: Vec<Known>,
}

impl Known {
    fn cost(&self) -> u32 {
        u32::from(self.triangles) + CLUSTER_COST
    }

    fn is_worth_it(&self) -> bool {
        self.value >= SAMPLES_A_TRIANGLE * PARTS_OF_SAMPLE * self.cost()
    }

    /// The larger, the more it hides for what it costs.
    fn density(&self) -> u64 {
        (u64::from(self.value) << 16) / u64::from(self.cost())
    }
}

impl Contributions {
    /// Whether a cluster of so many triangles that takes over this many samples at most might be worth drawing.
    pub fn is_promising(triangles: u32, samples: u64) -> bool {
        samples >= u64::from(SAMPLES_A_TRIANGLE * (triangles + CLUSTER_COST))
    }

    /// Forgets all.
    pub fn clear(&mut self) {
        self.known.clear();
        self.new.clear();
    }

    /// How many clusters are remembered.
    pub fn len(&self) -> usize {
        self.known.len()
    }

    /// Whether nothing is remembered.
    pub fn is_empty(&self) -> bool {
        self.known.is_empty()
    }

    /// The cluster at a place of the memory.
    pub fn id(&self, place: u32) -> ClusterId {
        self.known[place as usize].id
    }

    /// Puts the places of the clusters to draw first into `chosen`, in the order of their ids.
    pub fn choose(&self, budget: Budget, chosen: &mut Vec<u32>) {
        chosen.clear();
        let known = (0..).zip(&self.known);
        match budget {
            Budget::All => chosen.extend(known.map(|(place, _)| place)),
            Budget::Auto => {
                let worth_it = known.filter(|(_, known)| known.is_worth_it());
                chosen.extend(worth_it.map(|(place, _)| place));
            }
            Budget::Triangles(most) => {
                let mut left = most * QUARTERS_OF_BUDGET / 4;
                chosen.extend(known.map(|(place, _)| place));
                let known = |place: &u32| &self.known[*place as usize];
                chosen.sort_unstable_by_key(|place| (!known(place).density(), *place));
                let within = chosen.iter().take_while(|place| {
                    let triangles = u64::from(known(place).triangles);
                    let fits = triangles <= left;
                    left = left.saturating_sub(triangles);
                    fits
                });
                let count = within.count();
                chosen.truncate(count);
                chosen.sort_unstable();
            }
        }
    }

    /// Which clusters of an object are remembered: their numbers, in order.
    pub fn clusters_of(&self, object: u32) -> impl ExactSizeIterator<Item = u32> + Clone {
        let first = self.known.partition_point(|known| known.id.object < object);
        let count = self.known[first..].partition_point(|known| known.id.object == object);
        self.known[first..first + count]
            .iter()
            .map(|known| known.id.cluster)
    }

    /// Notes that the cluster at a place was hidden when its turn came.
    pub fn hidden(&mut self, place: u32) {
        self.known[place as usize].fate = Fate::Hidden;
    }

    /// Notes that the cluster at a place was drawn, and how many samples it took over.
    pub fn drawn(&mut self, place: u32, gain: u32) {
        let known = &mut self.known[place as usize];
        known.fate = Fate::Drawn;
        known.value += gain * PARTS_OF_SAMPLE;
    }

    /// Remembers a cluster that was drawn and is not known yet.
    pub fn add(&mut self, id: ClusterId, triangles: u32, gain: u32) {
        self.new.push(Known {
            id,
            value: 2 * gain * PARTS_OF_SAMPLE,
            triangles: triangles.min(u32::from(u8::MAX)) as u8,
            rest: REST,
            fate: Fate::Drawn,
        });
    }

    /// Ends a frame: values are halved, and what has added too little for too long is forgotten.
    pub fn end_frame(&mut self) {
        for known in self.known.iter_mut().chain(&mut self.new) {
            if known.fate != Fate::Left {
                known.value /= 2;
            }
            known.rest = if known.is_worth_it() {
                REST
            } else {
                known.rest.saturating_sub(1)
            };
            known.fate = Fate::Left;
        }
        self.known.retain(|known| known.rest > 0);
        if self.new.is_empty() {
            return;
        }
        self.new.sort_unstable_by_key(|known| known.id);
        self.merged.clear();
        let mut new = self.new.drain(..).peekable();
        for &known in &self.known {
            while let Some(before) = new.next_if(|new| new.id < known.id) {
                self.merged.push(before);
            }
            self.merged.push(known);
        }
        self.merged.extend(new);
        std::mem::swap(&mut self.known, &mut self.merged);
    }
}
