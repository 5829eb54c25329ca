//! Other names of presets: what people type who do not know what the authors of a table called it.

/// (other name, name). Words in another order, and types of skin by number, need
/// no entry ([`super::Preset::named`]).
#[rustfmt::skip]
pub const ALIASES: [(&str, &str); 93] = [
    ("beer", "budweiser-beer"), ("blonde-beer", "coors-light-beer"), ("bleach", "clorox"),
    ("candle", "wax"), ("candle-wax", "wax"), ("paraffin", "wax"), ("wax-yellow", "beeswax"),
    ("cappuccino", "cappuccino-powder"), ("coffee", "espresso"), ("mocha", "suisse-mocha-powder"),
    ("carrara", "marble-carrara"), ("marble-white", "marble-carrara"), ("thassos", "marble-thassos"),
    ("crema-marfil", "marble-cream"), ("botticino", "marble-cream"), ("marble-beige", "marble-cream"), ("travertine", "marble-cream"),
    ("marble-pink", "marble-rose"), ("rosa-portogallo", "marble-rose"), ("bardiglio", "marble-grey"), ("marble-gray", "marble-grey"),
    ("serpentine", "marble-green"), ("verde", "marble-green"), ("nero-marquina", "marble-black"),
    ("chicken", "chicken1"), ("chocolate", "openpbr-chocolate"), ("chocolate-dark", "openpbr-chocolate"),
    ("chocolate-milk", "regular-chocolate-milk"), ("cola", "coke"), ("juice", "apple-juice"), ("lemonade", "sprite"),
    ("eye", "openpbr-eye-sclera"), ("sclera", "openpbr-eye-sclera"), ("pearl", "openpbr-pearl"), ("snow", "openpbr-snow"),
    ("petroleum", "openpbr-petroleum"), ("crude-oil", "openpbr-petroleum"), ("oil", "olive-oil"),
    ("nephrite", "jade"), ("jade-green", "jade"), ("jadeite", "jade-imperial"), ("mutton-fat-jade", "jade-white"),
    ("glycerine-soap", "soap-glycerin"), ("soap-bar", "soap"),
    ("gummy-bear", "gummy"), ("gummy-red", "gummy"), ("gummi", "gummy"), ("wine-gum", "gummy"), ("jelly-bear", "gummy"),
    ("jello", "jelly"), ("gelatin", "jelly"), ("gelatine", "jelly"), ("resin", "amber"), ("succinite", "amber"),
    ("leaves", "leaf"), ("foliage", "leaf"), ("plant", "leaf"), ("flower", "petal"), ("rose-petal", "petal"), ("grape-green", "grape"),
    ("gouda", "cheese"), ("cheddar", "cheese"), ("egg", "egg-white"), ("beef", "meat"), ("steak", "meat"), ("flesh", "meat"), ("fish", "salmon"),
    ("milk", "whole-milk"), ("soy-milk", "regular-soy-milk"), ("milk-glass", "opal-glass"), ("onyx-honey", "onyx"),
    ("himalayan-salt", "salt-lamp"), ("rock-salt", "salt-lamp"), ("sea-water", "pacific-ocean-surface-water"), ("water", "pacific-ocean-surface-water"),
    ("wine", "merlot"), ("red-wine", "merlot"), ("white-wine", "chardonnay"),
    ("plastic", "plastic-white"), ("polyethylene", "plastic-white"), ("rubber", "silicone"), ("nail", "fingernail"), ("teeth", "tooth"),
    ("skin", "skin1"), ("skin-pale", "skin-i"), ("skin-fair", "skin-i"), ("skin-light", "skin-ii"), ("skin-olive", "skin-iii"),
    ("skin-medium", "skin-iv"), ("skin-tan", "skin-iv"), ("skin-brown", "skin-v"), ("skin-dark", "skin-vi"), ("lip", "lips"),
];

/// A name as it is looked up: lower case, words sorted; `fitzpatrick` is `skin`, and the types of skin have Roman numbers.
pub(super) fn key(name: &str) -> String {
    const ROMAN: [&str; 6] = ["i", "ii", "iii", "iv", "v", "vi"];
    let lower = name.trim().to_lowercase();
    let mut words: Vec<&str> = lower.split(['-', '_', ' ']).filter(|word| !word.is_empty()).collect();
    words.iter_mut().filter(|word| **word == "fitzpatrick").for_each(|word| *word = "skin");
    if words.contains(&"skin") {
        words.retain(|word| *word != "type");
        for word in &mut words {
            let number = word.parse::<usize>().ok().and_then(|n| ROMAN.get(n.wrapping_sub(1)));
            *word = number.copied().unwrap_or(word);
        }
    }
    words.sort_unstable();
    words.dedup();
    words.join("-")
}
