//! `KHR_node_visibility`: hides a node and everything below it, save cameras.

use super::Extension;
use crate::asset::{AssetError, Json, Loader};

pub(super) struct NodeVisibility;

impl Extension for NodeVisibility {
    fn name(&self) -> &str {
        "KHR_node_visibility"
    }

    fn visible(&self, _: &mut Loader<'_>, own: &Json<'_>) -> Result<bool, AssetError> {
        Ok(own.bool("visible")?.unwrap_or(true))
    }
}
