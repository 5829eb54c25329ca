//! Animations (glTF 2.0 §3.11, `KHR_animation_pointer`): the scene at a moment.
//!
//! A channel animates a property of the document, a pointer into it. So a moment is the document with other numbers in
//! it: values are written into a copy, and the copy is read as any other. Whatever reads a property, core or extension,
//! sees its animated value and need not know.

mod document;
mod property;
mod sampler;

use std::collections::{BTreeSet, HashMap};

use serde::Serialize;

pub(crate) use document::apply;
pub(crate) use property::Property;
pub use property::{MutableProperty, PropertyKind};
use sampler::{Sampler, Space};

use super::error::{AssetError, count, shorten};
use super::json::Json;
use super::loader::Loader;

/// Which animations play, and when; the default is the scene at rest.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Moment {
    /// Indices of animations. Where two animate the same property the later one counts.
    pub animations: Vec<usize>,
    /// Seconds from the beginning. Each channel holds its first value before, and its last one after its keyframes.
    pub time: f64,
}

/// An animation of the file.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct AnimationSummary {
    /// Its name.
    pub name: String,
    /// JSON pointer.
    pub pointer: String,
    /// Time of the first keyframe, seconds.
    pub start: f32,
    /// Time of the last keyframe, seconds.
    pub end: f32,
    /// Number of channels that can be played.
    pub channels: usize,
    /// Number of channels that are ignored.
    pub ignored: usize,
    /// Names of the properties that change, such as `rotation`.
    pub properties: Vec<String>,
}

/// A value that an animation gives a property.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Edit {
    pub property: Property,
    pub values: Vec<f64>,
}

/// A channel that can be played.
struct Channel {
    property: Property,
    sampler: Sampler,
    space: Space,
    fractions: bool,
}

impl Loader<'_> {
    /// What animations the file has, and what those of the moment change. Whatever is wrong with a channel is told, and
    /// the channel ignored.
    pub(super) fn animate(
        &mut self,
        moment: &Moment,
    ) -> Result<(Vec<AnimationSummary>, Vec<Edit>), AssetError> {
        let count = self.count("animations");
        if let Some(index) = moment.animations.iter().find(|&&i| i >= count) {
            let message = format!("there is no animation {index}, only {count}");
            return Err(AssetError::invalid("/animations", message));
        }
        let mut summaries = Vec::new();
        let mut edits = Vec::new();
        let mut order = vec![None; count];
        for (place, &index) in moment.animations.iter().enumerate() {
            order[index] = Some(place);
        }
        for (index, place) in order.into_iter().enumerate() {
            let animation = self.animation(index, place.map(|_| moment.time))?;
            summaries.push(animation.0);
            edits.extend(place.map(|place| (place, animation.1)));
        }
        edits.sort_by_key(|(place, _)| *place);
        Ok((summaries, self.unique(edits.into_iter().map(|(_, edits)| edits))))
    }

    /// One edit for each property, the last one.
    fn unique(&mut self, all: impl Iterator<Item = Vec<Edit>>) -> Vec<Edit> {
        let mut places: HashMap<Vec<String>, usize> = HashMap::new();
        let mut edits: Vec<Edit> = Vec::new();
        let mut replaced = 0;
        for edit in all.flatten() {
            match places.get(&edit.property.path).and_then(|&place| edits.get_mut(place)) {
                Some(earlier) => {
                    *earlier = edit;
                    replaced += 1;
                }
                None => {
                    places.insert(edit.property.path.clone(), edits.len());
                    edits.push(edit);
                }
            }
        }
        if replaced > 0 {
            let properties = count(replaced, "property is", "properties are");
            let message = format!("{properties} animated more than once; the last animation counts");
            self.note("/animations", message);
        }
        edits
    }

    /// An animation, and its edits where it plays.
    fn animation(
        &mut self,
        index: usize,
        time: Option<f64>,
    ) -> Result<(AnimationSummary, Vec<Edit>), AssetError> {
        let mut summary = AnimationSummary {
            name: format!("animation {index}"),
            pointer: format!("/animations/{index}"),
            ..AnimationSummary::default()
        };
        let mut edits = Vec::new();
        let opened = self.entry("animations", index, "/animations").and_then(|json| {
            let channels = json.get("channels").map(|c| c.items()).transpose()?;
            Ok((json, channels))
        });
        let Some((json, channels)) = self.usable(opened, "the animation")? else {
            return Ok((summary, edits));
        };
        summary.name = json.name_or(|| summary.name.clone());
        let mut properties = BTreeSet::new();
        let mut targets = BTreeSet::new();
        let mut samplers = HashMap::new();
        let mut range: Option<[f32; 2]> = None;
        for channel in channels.into_iter().flatten() {
            let read = self.channel(&json, &channel, &mut samplers);
            let Some(Some(read)) = self.usable(read, "the channel")? else {
                summary.ignored += 1;
                continue;
            };
            if !targets.insert(read.property.path.clone()) {
                let message = "animates what another channel of this animation animates; the last one counts";
                self.invalid(channel.pointer(), message)?;
            }
            summary.channels += 1;
            properties.extend(read.property.path.last().cloned());
            let [first, last] = read.sampler.range;
            range = Some(range.map_or([first, last], |[a, b]| [a.min(first), b.max(last)]));
            if let Some(time) = time {
                edits.extend(self.value(&channel, read, time)?);
            }
        }
        [summary.start, summary.end] = range.unwrap_or_default();
        summary.properties = properties.into_iter().collect();
        Ok((summary, edits))
    }

    /// What was read, or `None` with a message where it cannot be used.
    fn usable<T>(&mut self, read: Result<T, AssetError>, what: &str) -> Result<Option<T>, AssetError> {
        match read {
            Ok(read) => Ok(Some(read)),
            Err(e @ (AssetError::Strict(_) | AssetError::Limit { .. })) => Err(e),
            Err(e) => {
                self.invalid(e.pointer(), format!("{}; {what} is ignored", e.message()))?;
                Ok(None)
            }
        }
    }

    /// A channel; `None` where the format wants it ignored.
    fn channel(
        &mut self,
        animation: &Json<'_>,
        channel: &Json<'_>,
        samplers: &mut HashMap<usize, Option<Sampler>>,
    ) -> Result<Option<Channel>, AssetError> {
        let target = channel.object("target")?.ok_or_else(|| channel.error_at("target", "is missing"))?;
        let Some((pointer, from, core)) = self.target(&target)? else { return Ok(None) };
        let index = channel.usize("sampler")?.ok_or_else(|| channel.error_at("sampler", "is missing"))?;
        let sampler = match samplers.get(&index) {
            Some(known) => known.clone(),
            None => {
                let json = animation.get("samplers").and_then(|list| list.item(index));
                let json = json.ok_or_else(|| channel.error_at("sampler", "there is no such sampler"))?;
                let read = json.as_object().and_then(|_| self.sampler_of(&json));
                let read = self.usable(read, "the sampler")?;
                samplers.insert(index, read.clone());
                read
            }
        };
        let Some(sampler) = sampler else { return Ok(None) };
        let property = self.property(&pointer, &from)?;
        let wrong = |message: String| AssetError::invalid(sampler.output().pointer.clone(), message);
        let numbers = sampler.numbers().map_err(wrong)?;
        if numbers != property.numbers {
            let message = format!("has values of {numbers} numbers, but {pointer} has {}", property.numbers);
            return Err(wrong(message));
        }
        let output = sampler.output();
        let integers = output.component != super::Component::F32 && !output.normalized;
        let fractions =
            core && integers && matches!(property.kind, PropertyKind::Rotation | PropertyKind::Weights);
        if fractions {
            let message = "integers must be `normalized`; they are taken to be";
            self.invalid(&output.pointer, message)?;
        }
        let space = match property.kind {
            PropertyKind::Rotation => Space::Rotation,
            PropertyKind::Bool => Space::Steps,
            _ => Space::Numbers,
        };
        if space == Space::Steps && sampler.is_smooth() {
            let message = "what is true or false must be animated with STEP; it is taken to be";
            self.invalid(channel.pointer(), message)?;
        }
        Ok(Some(Channel { property, sampler, space, fractions }))
    }

    /// The pointer that a target means, the place that says it, and whether core glTF does; `None` where nothing that
    /// is known does.
    fn target(&mut self, target: &Json<'_>) -> Result<Option<(String, String, bool)>, AssetError> {
        if target.get("extensions").is_some() {
            for extension in self.options.registry.iter() {
                if let Some(own) = target.extension(extension.name())
                    && let Some(pointer) = extension.animation_target(self, &own)?
                {
                    return Ok(Some((pointer, own.pointer().to_owned(), false)));
                }
            }
        }
        let path = target.str("path")?.ok_or_else(|| target.error_at("path", "is missing"))?;
        let from = target.pointer_to("node");
        let Some(node) = target.usize("node")? else {
            self.note(target.pointer(), "has no node, so the channel is ignored");
            return Ok(None);
        };
        self.entry("nodes", node, &from)?;
        match path {
            "translation" | "rotation" | "scale" | "weights" => {
                Ok(Some((format!("/nodes/{node}/{path}"), from, true)))
            }
            _ => Err(target.error_at("path", format!("`{}` is nothing that a node has", shorten(path)))),
        }
    }

    fn value(&mut self, channel: &Json<'_>, read: Channel, time: f64) -> Result<Option<Edit>, AssetError> {
        let Channel { property, sampler, space, fractions } = read;
        self.spend_pose(property.numbers, channel.pointer())?;
        let mut values = sampler.at(time, space, property.numbers, fractions);
        if values.len() != property.numbers || !values.iter().all(|v| v.is_finite()) {
            let message = "the value is not finite; the channel is ignored";
            self.invalid(channel.pointer(), message)?;
            return Ok(None);
        }
        let [low, high] = property.range;
        if let Some(value) = values.iter().find(|&&v| v < low || v > high) {
            let message = format!("the value {value} is not between {low} and {high}, and is brought there");
            self.warn(channel.pointer(), message, None);
            values.iter_mut().for_each(|v| *v = v.clamp(low, high));
        }
        Ok(Some(Edit { property, values }))
    }
}
