//! Files that are read, changed and written: what `edit` and `convert` share.
//!
//! Nothing is written before the result has been loaded once, and a document appears complete or not at all. A `.gltf`
//! refers to files by relative paths, so its copy in another folder would be broken: it is refused, or the files are copied.

use super::Failure;
use super::args::LoadArgs;
use super::author_args::TargetArgs;
use super::beside::{self, NewFile};
use super::documents::{Documents, check_folder, is_standard_input, shown};
use super::job::{cannot_write, check_output};
use super::message::Reporter;
use super::pipeline::load_options;
use crate::asset::painting::Painting;
use crate::asset::{Asset, AssetError, LoadOptions, Loaded, load_bytes, load_stream};
use crate::author::paint::images::{self, NewImages, Place};
use crate::author::text::Tree;
use crate::author::{AuthoredFile, file};
use crate::film::atomic::{directory_of, write_atomically};
use std::path::{Path, PathBuf};

/// A file to be changed.
pub(super) struct Authored<'a> {
    args: &'a TargetArgs,
    options: LoadOptions,
    pub file: AuthoredFile,
    /// What it shows, or why it shows nothing.
    pub loaded: Result<Loaded, AssetError>,
}

/// The failure of reading a file.
pub(super) fn cannot_read(path: &Path, error: &AssetError) -> Failure {
    let (text, shown) = (error.to_string(), shown(path));
    let message = if text.contains(&shown) { text } else { format!("{shown}: {text}") };
    Failure::Cannot { message, advice: error.advice() }
}

/// Reads a file, or standard input, to be looked at as a document.
pub(super) fn read(args: &LoadArgs, options: &LoadOptions) -> Result<AuthoredFile, Failure> {
    let path = &args.input;
    let file = match is_standard_input(path) {
        true => AuthoredFile::from_stream(std::io::stdin().lock(), &options.limits),
        false => AuthoredFile::read(path, &options.limits),
    };
    file.map_err(|error| cannot_read(path, &error))
}

/// Loads what has been read. Standard input has no folder in which further files could be.
pub(super) fn load(args: &LoadArgs, bytes: &[u8], options: &LoadOptions) -> Result<Loaded, AssetError> {
    match is_standard_input(&args.input) {
        true => load_stream(bytes, options),
        false => load_bytes(bytes.to_vec(), &directory_of(&args.input), options),
    }
}

/// Changes every file that the arguments mean; `with` gets those of one file.
pub(super) fn each_target(
    args: &TargetArgs,
    mut with: impl FnMut(&TargetArgs, &Reporter) -> Result<(), Failure>,
) -> Result<(), Failure> {
    let input = &args.load.input;
    let from_stream = is_standard_input(input);
    if from_stream && args.in_place {
        return Err(Failure::Usage("standard input cannot be replaced: give -o FILE".to_owned()));
    }
    if from_stream && args.copy_resources {
        let text = "--copy-resources does not go with standard input, which has no folder to copy from";
        return Err(Failure::Usage(text.to_owned()));
    }
    if args.output.as_deref().is_some_and(is_standard_input) {
        return Err(Failure::Usage("to write to standard output, give -o /dev/stdout".to_owned()));
    }
    let all = Documents::all(input)?;
    let folder = args.output.as_ref().filter(|output| output.is_dir());
    if let Some(output) = args.output.as_ref().filter(|_| all.are_several()) {
        check_folder(input, output, "; or give --in-place")?;
    }
    if let Some(folder) = folder.filter(|_| from_stream) {
        let text = format!("{} is a folder: give standard input the name of a file", folder.display());
        return Err(Failure::Usage(text));
    }
    all.each(|document| {
        let mut target = args.clone();
        target.load.input = document.to_owned();
        if let (Some(folder), Some(name)) = (folder, document.file_name()) {
            target.output = Some(folder.join(name));
        }
        with(&target, &Reporter::of(args.quiet, all.named(document)))
    })
}

impl TargetArgs {
    /// The file that is written.
    pub fn written(&self) -> &Path {
        self.output.as_deref().unwrap_or(&self.load.input)
    }
}

impl<'a> Authored<'a> {
    /// Reads the input, and checks whether the output could be written.
    pub fn open(args: &'a TargetArgs, reporter: &Reporter) -> Result<Self, Failure> {
        let options = load_options(&args.load, LoadOptions::default());
        let (input, output) = (&args.load.input, args.written());
        let file = read(&args.load, &options)?;
        if !args.in_place && same_file(input, output) {
            return Err(Failure::advise(
                format!("{} is the input", output.display()),
                "give --in-place to replace it",
            ));
        }
        check_extension(&file, output)?;
        check_output(output)?;
        let loaded = load(&args.load, file.bytes(), &options);
        if let Err(error) = &loaded {
            reporter.warning(format!("{}: cannot be rendered: {error}", shown(input)));
        }
        Ok(Self { args, options, file, loaded })
    }

    /// Whether a document is the one that is there already, to the byte.
    pub fn is_unchanged(&self, text: &str) -> bool {
        self.file.with_document(text).is_ok_and(|bytes| bytes == self.file.bytes())
    }

    /// The paint of materials.
    pub fn painting(&self, materials: &[usize]) -> Result<Painting, Failure> {
        let asset = Asset::from_bytes(
            self.file.bytes().to_vec(),
            &directory_of(&self.args.load.input),
            &self.options,
        );
        asset.and_then(|asset| asset.painting(materials)).map_err(|e| cannot_read(&self.args.load.input, &e))
    }

    /// Writes the file with another document, and says what the loader thinks of the materials `changed`.
    pub fn write(&self, text: &str, changed: &[usize], reporter: &Reporter) -> Result<(), Failure> {
        let bytes = self.file.with_document(text).map_err(|e| cannot_read(&self.args.load.input, &e))?;
        self.check(bytes.clone(), changed, reporter)?;
        self.finish(&bytes, Vec::new())
    }

    /// As [`write`](Self::write), with images that are added to the document.
    pub fn write_with_images(
        &self,
        mut tree: Tree<'_>,
        images: &NewImages,
        changed: &[usize],
        reporter: &Reporter,
    ) -> Result<(), Failure> {
        if images.is_empty() {
            return self.write(&tree.to_string(), changed, reporter);
        }
        let unreadable = |e: AssetError| cannot_read(&self.args.load.input, &e);
        let place = images::place_inside(&self.file);
        if self.file.is_binary() {
            images.attach(&mut tree, place);
            let data = if matches!(place, Place::Chunk(_)) { images.chunk() } else { Vec::new() };
            let bytes = self.file.with_document_and_data(&tree.to_string(), &data).map_err(unreadable)?;
            self.check(bytes.clone(), changed, reporter)?;
            return self.finish(&bytes, Vec::new());
        }
        // What is loaded has the images in the document: their files are not there yet.
        let mut inside = tree.clone();
        images.attach(&mut inside, Place::Document);
        let bytes = self.file.with_document(&inside.to_string()).map_err(unreadable)?;
        self.check(bytes, changed, reporter)?;
        let files = beside::files(self.args.written(), images)?;
        let names: Vec<String> = files.iter().map(|file| file.name.clone()).collect();
        images.attach(&mut tree, Place::Files(&names));
        let bytes = self.file.with_document(&tree.to_string()).map_err(unreadable)?;
        self.finish(&bytes, files)
    }

    /// Loads what is to be written.
    fn check(&self, bytes: Vec<u8>, changed: &[usize], reporter: &Reporter) -> Result<(), Failure> {
        match load(&self.args.load, &bytes, &self.options) {
            Ok(mut result) => {
                let places: Vec<String> = changed.iter().map(|i| format!("/materials/{i}/")).collect();
                let surfaces: Vec<String> = changed.iter().map(|i| format!("material {i} ")).collect();
                result.diagnostics.retain(|d| {
                    let of_material = places.iter().any(|p| d.pointer.starts_with(p));
                    let of_vertices = d.pointer.ends_with("/COLOR_0")
                        && surfaces.iter().any(|surface| d.message.contains(surface));
                    d.severity > crate::asset::Severity::Note && (of_material || of_vertices)
                });
                reporter.diagnostics(&result.diagnostics);
                Ok(())
            }
            // What could not be loaded before is not the fault of the change.
            Err(_) if self.loaded.is_err() => Ok(()),
            Err(error) => Err(cannot_read(self.args.written(), &error)),
        }
    }

    /// Writes files beside the document, and then the document.
    fn finish(&self, bytes: &[u8], beside: Vec<NewFile>) -> Result<(), Failure> {
        let mut made = self.copy_resources()?;
        let remove = |made: &[PathBuf]| made.iter().for_each(|path| drop(std::fs::remove_file(path)));
        for NewFile { path, bytes, .. } in beside.into_iter().filter(|file| file.is_new) {
            let written: std::io::Result<()> = write_atomically(&path, |out| out.write_all(&bytes));
            if let Err(error) = written {
                remove(&made);
                return Err(cannot_write(&path, error));
            }
            made.push(path);
        }
        let output = self.args.written();
        let written = write_atomically(output, |out| out.write_all(bytes));
        if let Err(error) = written {
            remove(&made);
            return Err(cannot_write(output, error));
        }
        Ok(())
    }

    /// Sees to the files that the document refers to; the files that were copied.
    fn copy_resources(&self) -> Result<Vec<PathBuf>, Failure> {
        let input = &self.args.load.input;
        let (from, to) = (directory_of(input), directory_of(self.args.written()));
        if is_standard_input(input) || same_file(&from, &to) {
            return Ok(Vec::new());
        }
        let is_relative =
            |uri: &str| !uri.split(['/', '?', '#']).next().is_some_and(|first| first.contains(':'));
        let resources = self.file.resources().into_iter().filter(|(_, uri)| is_relative(uri));
        let mut copied: Vec<PathBuf> = Vec::new();
        for (pointer, uri) in resources {
            let done = match self.args.copy_resources {
                true => copy(&from, &to, &pointer, &uri, self.options.limits.file_bytes),
                false => Err(Failure::advise(
                    format!("{pointer}: the file {uri:?} is not in the folder of the output"),
                    "give --copy-resources, or write the output beside the input",
                )),
            };
            match done {
                Ok(path) => copied.extend(path),
                Err(failure) => {
                    copied.iter().for_each(|path| drop(std::fs::remove_file(path)));
                    return Err(failure);
                }
            }
        }
        Ok(copied)
    }
}

/// Copies one file unless it is there already; `None` if it was.
fn copy(from: &Path, to: &Path, pointer: &str, uri: &str, limit: u64) -> Result<Option<PathBuf>, Failure> {
    let (path, bytes) = file::resource(from, pointer, uri, limit).map_err(|e| cannot_read(from, &e))?;
    let target = to.join(path);
    if target.exists() {
        return match std::fs::read(&target) {
            Ok(there) if there == bytes => Ok(None),
            _ => Err(Failure::advise(
                format!("{pointer}: {} exists and is another file", target.display()),
                "write into an empty folder",
            )),
        };
    }
    std::fs::create_dir_all(directory_of(&target)).map_err(|e| cannot_write(&target, e))?;
    let written: std::io::Result<()> = write_atomically(&target, |out| out.write_all(&bytes));
    written.map(|()| Some(target.clone())).map_err(|e| cannot_write(&target, e))
}

fn same_file(a: &Path, b: &Path) -> bool {
    matches!((a.canonicalize(), b.canonicalize()), (Ok(a), Ok(b)) if a == b)
}

/// The name of the output should say what it holds.
fn check_extension(file: &AuthoredFile, output: &Path) -> Result<(), Failure> {
    let extension = output.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
    let (holds, other) = if file.is_binary() { ("glb", "gltf") } else { ("gltf", "glb") };
    if extension.as_deref() == Some(other) {
        return Err(Failure::advise(
            format!("{}: the input is a .{holds}, and the container is kept", output.display()),
            format!("give the output a name that ends with .{holds}"),
        ));
    }
    Ok(())
}
