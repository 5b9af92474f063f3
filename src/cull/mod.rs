//! The frame: from a camera to the set of objects that it may see.
//!
//! `frame` has its two ways. In order, the nearest objects in the frustum (HOM §3.2) are drawn as occluders, batch after batch,
//! each asked first whether what is drawn already hides it; now and then whole nodes of the hierarchy are asked, and a hidden one
//! answers for all below it (`draw`, `traverse`). By contribution, the clusters that the last frame needed are drawn (`recall`),
//! the hierarchy is asked (`traverse`, `seen`), and where an object shows that ought to be hidden, what covers it is drawn
//! (`gaps`, `covers`). Where nothing is remembered, the clusters that are seen from a viewpoint nearby stand in for those that were
//! needed, if somebody found them beforehand (`sampled`). With another depth representation than the default one, drawing and asking
//! are two passes, the first of which asks nothing (`two_passes`). On request, `clusters` tells which clusters of the survivors may be
//! seen. `staged` does a frame stage by stage, for a pipeline of frames.
//!
//! In exact mode the picture of the survivors is the picture of the scene. Every answer "hidden" rests on an occluder
//! surface strictly nearer at each sample the object could own; the nearest surface at a sample is never culled by
//! it, since nothing is strictly nearer there.

mod appearances;
mod ask;
mod clusters;
mod covers;
mod draw;
mod effort;
mod frame;
mod gaps;
mod marks;
mod occluders;
mod recall;
mod reuse;
mod rounds;
mod sampled;
mod seen;
mod skips;
mod staged;
mod statistics;
mod test;
mod translucent;
mod traverse;
mod two_passes;
mod views;
mod waiting;
mod world;

use std::sync::Arc;
use std::time::Instant;

use rayon::ThreadPoolBuildError;

use crate::occluders::{
    Budget, Contributions, DrawnCluster, FramesBack, LastFrame, Selection, Weighing,
};
use crate::occlusion::{Accuracy, DepthMap, DepthRepresentation, OcclusionBuffer};
use crate::prepare::{
    ClusterId, ClusteredMesh, ClusteredScene, Prepared, StaticCriteria, VisibilityGrid,
    VisibilityGridError,
};
use crate::scene::{Move, Scene, SceneError};
use crate::tasks::{Record, Stage, Tasks, stay_awake};
use crate::threads::Threads;
use crate::view::{Camera, Frustum, MapScale, PictureSize, Slack};

use clusters::ClusterWalk;
use effort::Worth;
use occluders::Occluders;
use reuse::Region;
use seen::Seen;
pub(crate) use staged::StagedFrame;
use traverse::{FrustumMemory, Subtrees};
use views::View;
use world::World;

pub use antumbra_simd::{Level, LevelUnavailable};
pub use appearances::Appearances;
pub use effort::{Effort, PriceLearner, Prices};
pub use skips::{Skip, Skips};
pub use statistics::{StageTimes, Statistics};

/// How to cull.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// The final picture's size.
    pub size: PictureSize,
    /// What may be lost.
    pub accuracy: Accuracy,
    /// Whether translucent surfaces are occluders too, where something may be lost: see
    /// [`OcclusionBuffer::draw_translucent`]. Exact frames ignore them.
    pub translucent: bool,
    /// How much coarser than the picture the occlusion map is.
    pub map_scale: MapScale,
    /// What the final pass may do otherwise than ours: [`Slack::GPU`] if a graphics processor draws the survivors. Exact frames then
    /// are right for its picture.
    pub slack: Slack,
    /// What is kept of the occluders' depth. With another representation than the default one a frame is HOM's two passes
    /// (§3.2): it draws its occluders, nearest first if they are to be chosen by contribution, and then asks every object's
    /// rectangle and nearest depth, and nothing more closely. With a map that is coarser than the picture, or a slack, it is the default
    /// one.
    pub depth: DepthRepresentation,
    /// How occluders are chosen.
    pub occluders: Selection,
    /// How many triangles may be drawn as occluders.
    pub budget: Budget,
    /// What makes objects unfit to be occluders, whatever the eye sees of them (HOM §7.1); by contribution nothing does.
    pub static_criteria: StaticCriteria,
    /// By weight: which objects are candidates, and how many are active.
    pub weighing: Weighing,
    /// By what was visible: in which frame.
    pub frames_back: FramesBack,
    /// By contribution: how many passes a frame has at the most (HOM §2.1.4). One draws what is remembered, two look a second time and
    /// draw what closes gaps, and so on; [`u32::MAX`]: as many as pay.
    pub most_passes: u32,
    /// Threads to use; 0: as many as the machine runs at once.
    pub threads: usize,
    /// The instruction set.
    pub level: Level,
    /// What a frame may leave out, and what drawing costs.
    pub effort: Effort,
}

impl Settings {
    /// Exact, by contribution, with a budget chosen by counted work, on all threads.
    pub fn new(size: PictureSize) -> Settings {
        Settings {
            size,
            accuracy: Accuracy::Exact,
            translucent: false,
            map_scale: MapScale::Full,
            slack: Slack::NONE,
            depth: DepthRepresentation::default(),
            occluders: Selection::default(),
            budget: Budget::default(),
            static_criteria: StaticCriteria::NONE,
            weighing: Weighing::default(),
            frames_back: FramesBack::default(),
            most_passes: u32::MAX,
            threads: 0,
            level: Level::best(),
            effort: Effort::default(),
        }
    }
}

/// What a camera may see, and what finding it took.
#[derive(Clone, Debug, Default)]
pub struct VisibleSet {
    /// The objects in the frustum that are not culled, in scene order.
    pub visible: Vec<u32>,
    /// The clusters that were drawn as occluders, in the order they were drawn. May hold some of objects that were found hidden
    /// after.
    pub occluders: Vec<DrawnCluster>,
    /// Counts.
    pub statistics: Statistics,
    /// Times.
    pub times: StageTimes,
}

/// Culls a scene, frame by frame.
#[derive(Debug)]
pub struct Culler {
    /// None for one thread: the caller's own does it all.
    threads: Option<Threads>,
    world: World,
    view: View,
    /// Views that were added.
    others: Vec<View>,
}

/// What a frame knows of those before it: what they needed, and what could be seen. It chooses occluders, and hides nothing.
#[derive(Clone, Debug, Default)]
pub struct Remembered {
    contributions: Contributions,
    seen: Seen,
    last: LastFrame,
    worth: Worth,
}

/// What a frame is made of, but for what it changes.
#[derive(Clone, Copy, Debug)]
struct Frame<'a> {
    scene: &'a Scene,
    occluders: &'a Occluders,
    subtrees: &'a Subtrees,
    /// Of this scene, if there is one.
    visibility_grid: Option<&'a VisibilityGrid>,
    /// Objects that stand out.
    salient: &'a [(u32, f32)],
    settings: &'a Settings,
    tasks: Tasks<'a>,
    /// When no more occluders are to be drawn, if that depends on the time.
    ends: Option<Instant>,
    /// What it costs to draw an object, on average, in nanoseconds.
    price: f64,
    /// What is to be found out again, if the rest is known from the last frame.
    region: Option<Region>,
}

impl Frame<'_> {
    /// All that the final pass may draw in the picture.
    fn frustum(&self, camera: &Camera) -> Frustum {
        Frustum::with_slack(camera, self.settings.size, self.settings.slack)
    }

    /// Whether another pass over gaps is allowed after so many.
    fn has_pass_left(&self, passes: u64) -> bool {
        passes + 1 < u64::from(self.settings.most_passes)
    }

    /// Whether a budget of time is spent. Without one, no clock is looked at.
    fn is_time_over(&self) -> bool {
        self.ends.is_some_and(|ends| Instant::now() >= ends)
    }
}

/// What task `task` of several takes, of `items` that are handed out by `share`.
fn share_of<T>(items: &[T], share: usize, task: usize) -> &[T] {
    items.chunks(share).nth(task).unwrap_or_default()
}

/// Makes sure that there are `count` things; those that are more than that are kept.
fn grow<T: Default>(things: &mut Vec<T>, count: usize) {
    if things.len() < count {
        things.resize_with(count, T::default);
    }
}

impl Culler {
    /// A culler for a scene, which is prepared for it.
    ///
    /// # Errors
    /// If the operating system gives no threads.
    pub fn new(scene: Arc<Scene>, settings: Settings) -> Result<Culler, ThreadPoolBuildError> {
        let threads = Threads::new(settings.threads)?;
        let prepared = threads.install(|| Prepared::new(scene));
        Ok(Culler::of_prepared(threads, &prepared, settings))
    }

    /// A culler for a scene that has been prepared.
    ///
    /// # Errors
    /// If the operating system gives no threads.
    pub fn with_prepared(
        prepared: &Prepared,
        settings: Settings,
    ) -> Result<Culler, ThreadPoolBuildError> {
        let threads = Threads::new(settings.threads)?;
        Ok(Culler::of_prepared(threads, prepared, settings))
    }

    fn of_prepared(threads: Threads, prepared: &Prepared, settings: Settings) -> Culler {
        Culler::of_world(threads, World::new(prepared), settings)
    }

    /// Another culler for the same scene, with other settings and nothing remembered; what is known of the scene is shared.
    ///
    /// # Errors
    /// If the operating system gives no threads.
    pub fn another(&self, settings: Settings) -> Result<Culler, ThreadPoolBuildError> {
        let threads = Threads::new(settings.threads)?;
        Ok(Culler::of_world(threads, self.world.clone(), settings))
    }

    /// Gives sampled visibility of this scene to the frames: to [`Selection::Sampled`], and to those by contribution that remember
    /// nothing. It chooses occluders and hides nothing, so a grid of other places, or of the scene as it was, costs time alone.
    ///
    /// # Errors
    /// If the grid names a cluster that the scene does not have; then there is none.
    pub fn set_visibility_grid(
        &mut self,
        grid: Arc<VisibilityGrid>,
    ) -> Result<(), VisibilityGridError> {
        self.world.set_visibility_grid(grid)
    }

    /// The sampled visibility that frames use, if there is any.
    pub fn visibility_grid(&self) -> Option<&Arc<VisibilityGrid>> {
        self.world.visibility_grid()
    }

    /// The clusters of the scene's occluders.
    pub fn clusters(&self) -> &ClusteredScene {
        self.world.occluders.clusters()
    }

    fn of_world(threads: Threads, world: World, settings: Settings) -> Culler {
        world.prepare_for(&settings, |work| threads.install(work));
        Culler {
            threads: (threads.current_num_threads() > 1).then_some(threads),
            world,
            view: View::new(settings),
            others: Vec::new(),
        }
    }

    /// The scene.
    pub fn scene(&self) -> &Arc<Scene> {
        &self.world.scene
    }

    /// The settings.
    pub fn settings(&self) -> &Settings {
        &self.view.settings
    }

    /// Says how much an object stands out against what may hide it, from 0 to 1: a lamp behind leaves (HOM §5.3.2). Where holes are
    /// ignored, such an object is culled only if it shows in no more than a share of `1 − salience` of what may be ignored in a tile;
    /// with 1, none of it. 0 at first.
    ///
    /// # Panics
    /// If there is no such object.
    pub fn set_salience(&mut self, object: u32, salience: f32) {
        self.world.set_salience(object, salience);
    }

    /// About what share of each visible object may be seen, more than 0 and up to 1, in their order
    /// ([`Visibility::Visible`](crate::occlusion::Visibility)): where a coarser model would do. Nothing if there was no frame yet.
    pub fn visibility_levels(&self, visible: &VisibleSet, levels: &mut Vec<f32>) {
        levels.clear();
        if let Some(buffer) = &self.view.buffer {
            let bounds = self.world.scene.bounds();
            let visible = visible.visible.iter();
            // What was taken for visible, or is never culled, may be hidden all the same.
            let level = |&object: &u32| buffer.test_aabb(&bounds[object as usize]).level();
            levels.extend(visible.map(level).map(|level| level.max(0.5 / 8.0)));
        }
    }

    /// How many threads are used.
    pub fn threads(&self) -> usize {
        self.threads
            .as_ref()
            .map_or(1, |threads| threads.current_num_threads())
    }

    /// What the last frame drew; none before the first.
    pub fn buffer(&self) -> Option<&OcclusionBuffer> {
        self.view.buffer.as_ref()
    }

    /// The depth of what the last frame drew, if it is not in the tiles of [`Culler::buffer`]: see [`Settings::depth`].
    pub fn depth_map(&self) -> Option<&DepthMap> {
        self.view.memory.two_passes.depth_map()
    }

    /// What the next frame knows of those before it.
    pub fn remembered(&self) -> &Remembered {
        &self.view.remembered
    }

    /// Moves objects, occluders among them: from the next frame on they are where they go, in every way. See [`Scene::move_objects`].
    ///
    /// The scene is copied first if others share it, but for its meshes; once is enough.
    ///
    /// # Errors
    /// Those of [`Scene::move_objects`]. Nothing has moved then.
    pub fn move_objects(&mut self, moves: &[Move]) -> Result<(), SceneError> {
        self.world.move_objects(moves)
    }

    /// Makes pictures of another size from the next frame on. What is remembered stays.
    pub fn resize(&mut self, size: PictureSize) {
        self.view.resize(size);
    }

    /// Says what drawing costs from the next frame on: as [`Settings::effort`] does at first.
    pub fn set_prices(&mut self, prices: Prices) {
        self.view.settings.effort.prices = prices;
    }

    /// Goes back to what an earlier frame knew of those before it.
    pub fn recall(&mut self, remembered: &Remembered) {
        self.view.forget_answer();
        self.view.remembered.clone_from(remembered);
    }

    /// Forgets all frames.
    pub fn forget(&mut self) {
        self.view.forget_answer();
        self.view.remembered.clear();
    }

    /// The objects whose boxes are not wholly outside one plane of a camera's frustum, in scene order: those that culling
    /// chooses from. (A frame does not look at all of them.)
    pub fn in_frustum(&self, camera: &Camera) -> Vec<u32> {
        let frame = self.frame_of(Tasks::ALONE);
        let frustum = frame.frustum(camera);
        let mut found = Vec::new();
        traverse::in_frustum(&frame, &frustum, &mut FrustumMemory::default(), &mut found);
        found
    }

    /// The same, into the memory of an earlier answer: frustum culling alone, as fast as it is here.
    pub fn in_frustum_into(&mut self, camera: &Camera, found: &mut Vec<u32>) {
        let (world, view) = (&self.world, &mut self.view);
        in_tasks(&self.threads, |tasks| {
            let frame = world.frame_of(&view.settings, tasks);
            frame.find_in_frustum(camera, &mut view.memory);
            found.clear();
            found.extend_from_slice(&view.memory.in_frustum);
        });
    }

    /// Finds what a camera may see, where given clusters are the occluders, whatever the settings say of these: each that is
    /// in the picture and not hidden behind others is drawn, and all objects in the frustum are asked. Knows nothing of earlier
    /// frames, and later ones will not know of it.
    ///
    /// # Panics
    /// If there is no such object or cluster.
    pub fn cull_behind(&mut self, camera: &Camera, clusters: &[ClusterId], found: &mut VisibleSet) {
        let mut given = self.world.occluders.remembered(&self.world.scene, clusters);
        let (world, view) = (&self.world, &mut self.view);
        in_tasks(&self.threads, |tasks| {
            view.frame_behind(world, tasks, camera, &mut given, found);
        });
    }

    /// Finds what a camera may see.
    pub fn cull(&mut self, camera: &Camera) -> VisibleSet {
        let mut found = VisibleSet::default();
        self.cull_into(camera, &mut found);
        found
    }

    /// Finds what a camera may see, and puts it into the memory of an earlier answer: when frames are alike, none
    /// allocates.
    pub fn cull_into(&mut self, camera: &Camera, found: &mut VisibleSet) {
        let (world, view) = (&self.world, &mut self.view);
        in_tasks(&self.threads, |tasks| {
            view.frame(world, tasks, camera, found);
        });
    }

    /// Which clusters of the objects that the last frame found visible may be seen: an object that reaches everywhere may be
    /// visible while most of its clusters are not. Clusters are in the order of their ids; those of an object are counted as in
    /// [`Culler::occluder_of`]. Appends the objects to `whole` that are to be drawn as a whole, since there is more to them than
    /// clusters: they are translucent or cut out, hide nothing, or have a proxy in their place.
    ///
    /// Exact if culling is: every cluster that owns a pixel is named. Nothing if there was no frame yet.
    ///
    /// Whether occlusion pays is asked of objects ([`Effort::skip`]), and a frame without it names all clusters: who draws by clusters
    /// says that it is not to be left out.
    pub fn visible_clusters(&self, visible: &VisibleSet, whole: &mut Vec<u32>) -> Vec<ClusterId> {
        let mut found = Vec::new();
        let Some(buffer) = &self.view.buffer else {
            return found;
        };
        let frame = self.frame_of(Tasks::ALONE);
        let mut walk = ClusterWalk::default();
        for &object in &visible.visible {
            if !walk.find_not_hidden(&frame, buffer, object, &mut found) {
                whole.push(object);
            }
        }
        found
    }

    /// The clusters of what an object is drawn as when it is an occluder; none if it is none.
    pub fn occluder_of(&self, object: u32) -> Option<&ClusteredMesh> {
        let object = self.world.scene.objects().get(object as usize)?;
        self.world.occluders.mesh_of(object)
    }

    fn frame_of<'a>(&'a self, tasks: Tasks<'a>) -> Frame<'a> {
        self.world.frame_of(&self.view.settings, tasks)
    }

    /// Finds what a camera may see, on the calling thread alone but in the tasks that a frame on so many threads would
    /// have, and says what each took.
    pub fn cull_recorded(
        &mut self,
        camera: &Camera,
        threads: usize,
        found: &mut VisibleSet,
    ) -> Vec<Stage> {
        let record = Record::start();
        let tasks = Tasks::recorded(threads, &record);
        self.view.frame(&self.world, tasks, camera, found);
        record.finish()
    }
}

impl Remembered {
    fn clear(&mut self) {
        self.contributions.clear();
        self.seen.clear();
        self.last.clear();
        self.worth.clear();
    }
}

/// Does something in tasks: of several threads, or if there are none on the calling one alone.
fn in_tasks(threads: &Option<Threads>, work: impl FnOnce(Tasks<'_>) + Send) {
    match threads {
        None => work(Tasks::ALONE),
        Some(threads) => {
            let tasks = Tasks::shared(threads.current_num_threads());
            threads.install(|| stay_awake(|| work(tasks)));
        }
    }
}
