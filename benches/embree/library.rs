//! The few functions of Embree 3 that the bench calls, loaded at run time.
//!
//! Declarations follow `rtcore_*.h` of version 3.13: <https://github.com/RenderKit/embree/tree/v3.13.5/include/embree3>.

use glam::Vec3;
use libloading::{Library, Symbol};
use nephrite::geometry::Ray;
use std::ffi::{c_char, c_void};
use std::sync::atomic::{AtomicIsize, Ordering};

/// An object behind a pointer that only the library reads.
type Handle = *mut c_void;

const GEOMETRY_TYPE_TRIANGLE: u32 = 0;
const BUFFER_TYPE_INDEX: u32 = 0;
const BUFFER_TYPE_VERTEX: u32 = 1;
const FORMAT_UINT3: u32 = 0x5003;
const FORMAT_FLOAT3: u32 = 0x9003;
const BUILD_QUALITY_HIGH: u32 = 2;
const SCENE_FLAG_ROBUST: u32 = 1 << 2;
const DEVICE_PROPERTY_VERSION: u32 = 0;
const INVALID: u32 = u32::MAX;

/// `RTCRayHit`: `RTCRay`, then `RTCHit`.
#[repr(C, align(16))]
#[derive(Clone, Copy)]
pub struct RayHit {
    origin: [f32; 3],
    t_near: f32,
    direction: [f32; 3],
    time: f32,
    /// End of the ray; the distance once it has hit.
    pub t_far: f32,
    mask: u32,
    id: u32,
    flags: u32,
    normal: [f32; 3],
    u: f32,
    v: f32,
    /// Triangle that was hit.
    pub triangle: u32,
    geometry: u32,
    instance: u32,
}

impl RayHit {
    /// A ray that has hit nothing yet.
    #[inline]
    pub fn new(ray: &Ray) -> Self {
        Self {
            origin: ray.origin.into(),
            t_near: 0.0,
            direction: ray.direction.into(),
            time: 0.0,
            t_far: ray.t_max,
            mask: u32::MAX,
            id: 0,
            flags: 0,
            normal: [0.0; 3],
            u: 0.0,
            v: 0.0,
            triangle: INVALID,
            geometry: INVALID,
            instance: INVALID,
        }
    }

    /// Whether it has hit.
    pub fn is_hit(&self) -> bool {
        self.geometry != INVALID
    }
}

/// `RTCIntersectContext`; flags of zero stand for incoherent rays, the library's default.
#[repr(C)]
struct Context {
    flags: u32,
    filter: *const c_void,
    instance: u32,
}

type Intersect = unsafe extern "C" fn(Handle, *mut Context, *mut RayHit);

/// Bytes that the library holds for its scenes, as its memory monitor counts them.
static ALLOCATED: AtomicIsize = AtomicIsize::new(0);

unsafe extern "C" fn count_memory(_: *mut c_void, bytes: isize, _post: bool) -> bool {
    ALLOCATED.fetch_add(bytes, Ordering::Relaxed);
    true
}

/// The library and a device.
pub struct Embree {
    library: Library,
    device: Handle,
}

impl Embree {
    /// Loads Embree 3 from where the system's loader finds it, with `threads` threads to build with.
    pub fn load(threads: usize) -> Result<Self, libloading::Error> {
        let names = ["libembree3.so.3", "libembree3.so", "libembree3.dylib", "embree3.dll"];
        // SAFETY: the library's initialization has no requirements.
        let found = names.iter().map(|name| unsafe { Library::new(name) });
        let library = found.reduce(|a, b| a.or(b)).expect("there are names")?;
        let config = format!("threads={threads}\0");
        // SAFETY (here and below): types are those of the headers, handles come from the library itself.
        let device = unsafe {
            let new: Symbol<unsafe extern "C" fn(*const c_char) -> Handle> = library.get(b"rtcNewDevice")?;
            let device = new(config.as_ptr().cast());
            type Monitor = unsafe extern "C" fn(*mut c_void, isize, bool) -> bool;
            let set: Symbol<unsafe extern "C" fn(Handle, Monitor, *mut c_void)> =
                library.get(b"rtcSetDeviceMemoryMonitorFunction")?;
            set(device, count_memory, std::ptr::null_mut());
            device
        };
        Ok(Self { library, device })
    }

    /// Version, as in 3.13.5.
    pub fn version(&self) -> Result<String, libloading::Error> {
        let version = unsafe {
            let get: Symbol<unsafe extern "C" fn(Handle, u32) -> isize> =
                self.library.get(b"rtcGetDeviceProperty")?;
            get(self.device, DEVICE_PROPERTY_VERSION)
        };
        Ok(format!("{}.{}.{}", version / 10_000, version / 100 % 100, version % 100))
    }

    /// Builds a scene of one mesh with high quality.
    pub fn build(
        &self,
        positions: &[Vec3],
        triangles: &[[u32; 3]],
        robust: bool,
    ) -> Result<Scene<'_>, libloading::Error> {
        type NewObject = unsafe extern "C" fn(Handle) -> Handle;
        type SetNumber = unsafe extern "C" fn(Handle, u32);
        type Act = unsafe extern "C" fn(Handle);
        type NewBuffer = unsafe extern "C" fn(Handle, u32, u32, u32, usize, usize) -> *mut c_void;
        let before = ALLOCATED.load(Ordering::Relaxed);
        unsafe {
            let new_scene: Symbol<NewObject> = self.library.get(b"rtcNewScene")?;
            let new_geometry: Symbol<unsafe extern "C" fn(Handle, u32) -> Handle> =
                self.library.get(b"rtcNewGeometry")?;
            let new_buffer: Symbol<NewBuffer> = self.library.get(b"rtcSetNewGeometryBuffer")?;
            let set_quality: Symbol<SetNumber> = self.library.get(b"rtcSetSceneBuildQuality")?;
            let set_geometry_quality: Symbol<SetNumber> = self.library.get(b"rtcSetGeometryBuildQuality")?;
            let set_flags: Symbol<SetNumber> = self.library.get(b"rtcSetSceneFlags")?;
            let commit_geometry: Symbol<Act> = self.library.get(b"rtcCommitGeometry")?;
            let attach: Symbol<unsafe extern "C" fn(Handle, Handle) -> u32> =
                self.library.get(b"rtcAttachGeometry")?;
            let release_geometry: Symbol<Act> = self.library.get(b"rtcReleaseGeometry")?;
            let commit: Symbol<Act> = self.library.get(b"rtcCommitScene")?;
            let scene = new_scene(self.device);
            set_quality(scene, BUILD_QUALITY_HIGH);
            set_flags(scene, if robust { SCENE_FLAG_ROBUST } else { 0 });
            let geometry = new_geometry(self.device, GEOMETRY_TYPE_TRIANGLE);
            set_geometry_quality(geometry, BUILD_QUALITY_HIGH);
            let count = positions.len();
            let buffer = new_buffer(geometry, BUFFER_TYPE_VERTEX, 0, FORMAT_FLOAT3, size_of::<Vec3>(), count);
            buffer.cast::<Vec3>().copy_from_nonoverlapping(positions.as_ptr(), count);
            let count = triangles.len();
            let buffer = new_buffer(geometry, BUFFER_TYPE_INDEX, 0, FORMAT_UINT3, 12, count);
            buffer.cast::<[u32; 3]>().copy_from_nonoverlapping(triangles.as_ptr(), count);
            commit_geometry(geometry);
            attach(scene, geometry);
            release_geometry(geometry);
            commit(scene);
            let intersect: Symbol<Intersect> = self.library.get(b"rtcIntersect1")?;
            let release: Symbol<Act> = self.library.get(b"rtcReleaseScene")?;
            let bytes = ALLOCATED.load(Ordering::Relaxed) - before;
            Ok(Scene {
                handle: scene,
                intersect: *intersect,
                release: *release,
                bytes,
                _library: &self.library,
            })
        }
    }
}

impl Drop for Embree {
    fn drop(&mut self) {
        unsafe {
            if let Ok(release) = self.library.get::<unsafe extern "C" fn(Handle)>(b"rtcReleaseDevice") {
                release(self.device);
            }
        }
    }
}

/// A committed scene.
pub struct Scene<'a> {
    handle: Handle,
    intersect: Intersect,
    release: unsafe extern "C" fn(Handle),
    /// Bytes of its buffers and its hierarchy.
    pub bytes: isize,
    _library: &'a Library,
}

impl Scene<'_> {
    /// `rtcIntersect1`: the closest hit.
    #[inline]
    pub fn intersect(&self, ray: &Ray) -> RayHit {
        let mut hit = RayHit::new(ray);
        let mut context = Context { flags: 0, filter: std::ptr::null(), instance: INVALID };
        unsafe { (self.intersect)(self.handle, &mut context, &mut hit) };
        hit
    }
}

impl Drop for Scene<'_> {
    fn drop(&mut self) {
        unsafe { (self.release)(self.handle) };
    }
}

/// Calls `f` with numbers that are too small to be normal taken for zero, as Embree asks of its callers.
#[cfg(target_arch = "x86_64")]
pub fn flush_to_zero<T>(f: impl FnOnce() -> T) -> T {
    use std::arch::asm;
    /// Bits of MXCSR: denormals are zero, and results are flushed to zero.
    const ZEROS: u32 = 1 << 6 | 1 << 15;
    let mut before = 0_u32;
    // SAFETY: these bits change the treatment of denormals alone, and they are put back.
    unsafe { asm!("stmxcsr [{}]", in(reg) &mut before) };
    let during = before | ZEROS;
    unsafe { asm!("ldmxcsr [{}]", in(reg) &during) };
    let out = f();
    unsafe { asm!("ldmxcsr [{}]", in(reg) &before) };
    out
}

/// Calls `f`.
#[cfg(not(target_arch = "x86_64"))]
pub fn flush_to_zero<T>(f: impl FnOnce() -> T) -> T {
    f()
}
