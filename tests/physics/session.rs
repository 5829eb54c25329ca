//! Sessions: a picture is a function of its scene, its view, its settings and the numbers of its samples, however these
//! were shared out over passes, films and days.

use crate::lab::*;
use crate::views::{above, checkers};
use glam::{Affine3A, Vec3};
use nephrite::film::{Film, Window};
use nephrite::scene::*;
use nephrite::subsurface::Registry;
use nephrite::transport::{
    FirstEvent, LightLayer, LightSource, LightTag, Plan, RenderControl, RenderOptions, Session, View,
};
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::{Duration, Instant};

/// Samples of the whole picture.
const SPP: u32 = 13;
/// Moments of the shutter, each with so many of them.
const MOMENTS: [u32; 3] = [4, 4, 5];

/// Texels about as wide as what is averaged, below a ball of milk that moves, above a ground that catches its shadow.
fn scene_at(moment: usize) -> Arc<Scene> {
    let mut scene = checkers(9, Minify::Footprint);
    let ball = single(icosphere(0.2, 2, true), milk(), EnvironmentDescription::default());
    let material = scene.materials.len() as u32;
    scene.materials.extend(ball.materials);
    scene.meshes.push(MeshDescription {
        triangle_materials: vec![material; ball.meshes[0].triangles.len()],
        ..ball.meshes[0].clone()
    });
    scene.instances.push(InstanceDescription {
        name: String::new(),
        pointer: String::new(),
        mesh: 1,
        transform: Affine3A::from_translation(Vec3::new(0.2 * moment as f32, 0.3, 0.0)),
    });
    // The square leaves a rim of the background, and of the ground below, open.
    scene.instances[0].transform = Affine3A::from_scale(Vec3::splat(0.8));
    scene.environment = EnvironmentDescription::Constant(Vec3::new(0.5, 0.75, 1.0));
    Arc::new(Scene::build(scene).expect("builds"))
}

fn milk() -> MaterialDescription {
    subsurface(Vec3::new(0.1, 1.0, 2.0), Vec3::splat(20.0), 0.3, 1.4, 0.2)
}

fn wanted() -> RenderOptions {
    options(above(), 21, SPP).with(|o| {
        o.view.transparent = true;
        o.view.ground = Some(-0.5);
        o.settings.seed = 5;
    })
}

fn session(first_sample: u32, moment: usize) -> Session<Arc<Scene>> {
    let RenderOptions { view, settings, .. } = wanted();
    let session = Session::new(scene_at(moment), view, settings, 0, &Registry::standard()).expect("begins");
    session.starting_at(first_sample)
}

/// The samples from `first` on as one film, with each moment of the shutter for its own.
fn exposed(first: u32, count: u32, passes: &[u32]) -> Film {
    let mut session = session(first, 0);
    let mut next = first;
    let mut sizes = passes.iter().copied().cycle();
    let ends = [MOMENTS[0], MOMENTS[0] + MOMENTS[1], SPP];
    for (moment, end) in ends.into_iter().enumerate() {
        session.set_scene(scene_at(moment));
        while next < end && next < first + count {
            let pass = sizes.next().unwrap_or(1).min(end - next).min(first + count - next);
            assert!(session.pass(&Plan::Everywhere(pass), &()));
            next += pass;
        }
    }
    session.into_film()
}

/// The largest difference of two films' pictures, alpha and layers included.
fn difference(a: &Film, b: &Film) -> f32 {
    let [a, b] = [a, b].map(|film| {
        let picture = film.develop();
        let pixels = picture.pixels.iter().flat_map(|p| p.to_array());
        let layers = picture.layers.iter().flat_map(|l| &l.channels).flat_map(|c| c.values.clone());
        pixels.chain(picture.alpha.clone().expect("alpha")).chain(layers).collect::<Vec<f32>>()
    });
    assert_eq!(a.len(), b.len());
    a.iter().zip(&b).map(|(a, b)| (a - b).abs() / a.abs().max(1.0)).fold(0.0, f32::max)
}

#[test]
fn any_partition_of_the_samples_in_any_order_makes_the_picture() {
    let whole = exposed(0, SPP, &[SPP]);
    assert_eq!(whole.least_count(), SPP);
    // However large the passes of one film are, sums grow sample by sample: equal bits.
    for passes in [&[1][..], &[3, 1], &[2, 5]] {
        assert!(exposed(0, SPP, passes) == whole, "{passes:?}");
    }
    // Films that are added up are rounded otherwise.
    let cuts: [&[(u32, u32)]; 3] = [&[(0, 6), (6, 7)], &[(9, 4), (0, 2), (2, 7)], &[(12, 1), (5, 7), (0, 5)]];
    for ranges in cuts {
        let mut films = ranges.iter().map(|&(first, count)| exposed(first, count, &[2]));
        let mut sum = films.next().expect("some");
        films.for_each(|film| sum.merge(&film).expect("of one kind"));
        let found = difference(&sum, &whole);
        assert!(found < 1e-6, "{ranges:?}: {found}");
    }
    // Other samples are another picture.
    assert!(difference(&exposed(1, 4, &[4]), &exposed(0, 4, &[4])) > 1e-3);
}

#[test]
fn a_film_that_was_saved_goes_on_to_the_bit() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("half.film");
    let mut first = session(0, 1);
    assert!(first.pass(&Plan::Everywhere(5), &()));
    first.film().save(&path, &serde_json::json!({"of": "checkers"})).expect("saves");
    assert!(first.pass(&Plan::Everywhere(8), &()));

    let (film, _) = Film::load(&path).expect("loads");
    let mut second = session(0, 1);
    second.resume(film).expect("of one kind");
    assert!(second.pass(&Plan::Everywhere(8), &()));
    assert!(second.film() == first.film());
    let small = options(above(), 8, 1);
    let mut other =
        Session::new(scene_at(0), small.view, small.settings, 0, &Registry::standard()).expect("begins");
    assert!(other.resume(second.into_film()).is_err());
}

#[test]
fn passes_over_some_pixels_leave_the_others_alone() {
    let window = Window { x: 3, y: 15, width: 7, height: 30 };
    let mut session = session(0, 0);
    assert!(session.pass(&Plan::Within(window, 2), &()));
    let size = session.view().width;
    let inside = |i: u32| (3..10).contains(&(i % size)) && i / size >= 15;
    let counts = session.film().counts().to_vec();
    for (i, count) in counts.iter().enumerate() {
        assert_eq!(*count, if inside(i as u32) { 2 } else { 0 });
    }
    // What is missing makes it the film of everything.
    let missing = counts.iter().map(|count| 3 - count).collect();
    assert!(session.pass(&Plan::Each(missing), &()));
    let mut whole = self::session(0, 0);
    assert!(whole.pass(&Plan::Everywhere(3), &()));
    assert!(session.film() == whole.film());
    session.clear();
    assert_eq!(session.film().least_count(), 0);
    // A larger view is another film; another camera is not.
    assert!(whole.set_view(wanted().with(|o| o.view.camera.name = "b".into()).view).is_ok());
    assert_eq!(whole.film().least_count(), 3);
    assert!(whole.set_view(wanted().with(|o| o.view.width = 30).view).is_ok());
    assert_eq!((whole.film().least_count(), whole.film().width()), (0, 30));
    assert!(whole.set_view(wanted().with(|o| o.view.width = 0).view).is_err());
}

/// Asks to stop after some tiles, and remembers when.
struct Impatient {
    tiles: AtomicU32,
    asked: std::sync::OnceLock<Instant>,
}

impl RenderControl for Impatient {
    fn advance(&self, _: u64, _: u64) {
        if self.tiles.fetch_add(1, Ordering::Relaxed) >= 3 {
            self.asked.get_or_init(Instant::now);
        }
    }
    fn cancelled(&self) -> bool {
        self.asked.get().is_some()
    }
}

#[test]
fn a_pass_ends_soon_after_it_is_cancelled_and_leaves_complete_tiles() {
    // Milk without end: each sample takes long.
    let white = subsurface(Vec3::ZERO, Vec3::splat(3000.0), 0.0, 1.4, 0.2);
    let scene = single(icosphere(1.0, 3, true), white, EnvironmentDescription::Constant(Vec3::ONE));
    let scene = Arc::new(Scene::build(scene).expect("builds"));
    let RenderOptions { view, settings, .. } = options(above(), 64, 1);
    let mut session = Session::new(scene, view, settings, 2, &Registry::standard()).expect("begins");
    let control = Impatient { tiles: AtomicU32::new(0), asked: std::sync::OnceLock::new() };
    assert!(!session.pass(&Plan::Everywhere(2), &control));
    let took = control.asked.get().expect("was asked").elapsed();
    // 20 ms are promised; machines that test are busy.
    assert!(took < Duration::from_millis(200), "{took:?}");
    let counts = session.film().counts();
    assert!(counts.iter().all(|c| *c == 0 || *c == 2));
    let tile = |x: usize, y: usize| counts[16 * y * 64 + 16 * x];
    for (i, count) in counts.iter().enumerate() {
        assert_eq!(*count, tile(i % 64 / 16, i / 64 / 16));
    }
    // The pass again, for those that are missing.
    let missing = counts.iter().map(|count| 2 - count).collect();
    assert!(session.pass(&Plan::Each(missing), &()));
    assert_eq!(session.film().least_count(), 2);
}

/// Layers that share out all light add up to the picture, sample by sample; what they say is what there is.
#[test]
fn layers_of_light_add_up_to_the_picture() {
    use FirstEvent::{Medium, None as Nothing, Refraction, Surface};
    // The ball of milk on its square, in a sky, with a lamp beside and a light without size above.
    let mut scene = SceneDescription::clone(&scene_at(0).description);
    let lamp = scene.materials.len() as u32;
    scene.materials.push(MaterialDescription { emission: Vec3::splat(8.0), ..matte(0.0) });
    let lamp_mesh = MeshDescription { triangle_materials: vec![lamp; 20], ..icosphere(0.1, 0, false) };
    scene.meshes.push(lamp_mesh);
    scene.instances.push(place(2, Affine3A::from_translation(Vec3::new(-0.5, 0.4, 0.3))));
    scene.lights.push(PunctualLight {
        name: String::new(),
        intensity: Vec3::ONE,
        position: Vec3::new(0.5, 1.0, 0.0),
        direction: Vec3::NEG_Y,
        range: None,
        kind: PunctualKind::Point,
    });
    let scene = Arc::new(Scene::build(scene).expect("builds"));
    let RenderOptions { mut view, settings, .. } = options(above(), 21, 1);
    let firsts = [Nothing, Surface, Refraction, Medium];
    let layer =
        |name: String, holds: Box<dyn Fn(&LightTag) -> bool + Send + Sync>| LightLayer::new(&name, holds);
    view.light_layers = firsts
        .into_iter()
        .map(|first| layer(format!("{first:?}"), Box::new(move |tag| tag.first == first)))
        .chain([
            layer("environment".into(), Box::new(|tag| tag.light == LightSource::Environment)),
            layer("point".into(), Box::new(|tag| tag.light == LightSource::Punctual(0))),
            layer("square".into(), Box::new(|tag| tag.light == LightSource::Surface(0))),
            layer("lamp".into(), Box::new(|tag| tag.light == LightSource::Surface(2))),
            layer("single".into(), Box::new(|tag| tag.first == Refraction && tag.scatterings == 1)),
            layer("milk".into(), Box::new(|tag| tag.object == Some(1))),
        ])
        .collect();
    let plain = options(above(), 21, 1).view;
    let film = |view: View| {
        let models = Registry::standard();
        let session = Session::new(scene.clone(), view, settings.clone(), 0, &models);
        let mut session = session.expect("begins").starting_at(7);
        assert!(session.pass(&Plan::Everywhere(4), &()));
        session.into_film().develop()
    };
    let picture = film(view);
    let mean = |name: &str| {
        let layer = picture.layers.iter().find(|l| l.name == name).expect("is there");
        let of = |c: usize| layer.channels[c].values.iter().map(|v| f64::from(*v)).sum::<f64>() / 441.0;
        [of(0), of(1), of(2)]
    };
    assert_eq!(film(plain).pixels, picture.pixels, "layers change nothing");
    let whole = picture.mean();
    let sums: [&[&str]; 2] =
        [&["None", "Surface", "Refraction", "Medium"], &["environment", "point", "square", "lamp"]];
    for names in sums {
        for (c, whole) in whole.iter().enumerate() {
            let sum: f64 = names.iter().map(|name| mean(name)[c]).sum();
            assert!((sum - whole).abs() < 1e-5 * whole, "{names:?}: {sum} instead of {whole}");
        }
    }
    // Nothing of this is empty but the medium around the camera, which there is not. Unlit squares shine by themselves.
    for name in ["None", "Refraction", "environment", "lamp", "square", "single", "milk"] {
        assert!(mean(name)[0] > 0.0, "{name}");
    }
    assert_eq!(mean("Medium"), [0.0; 3]);
    // Some, and not all, of what comes out of milk has been scattered once.
    assert!(mean("single")[0] < mean("Refraction")[0]);
    assert!(mean("milk")[0] >= mean("Refraction")[0]);
}
