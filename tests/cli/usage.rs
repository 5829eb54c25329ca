//! What is said to people who type what they know from elsewhere.

use super::util::{Sandbox, tetrahedra, triangle};

#[test]
fn what_was_probably_meant_is_said() {
    let sandbox = Sandbox::new();
    sandbox.file("a.gltf", triangle(""));
    sandbox.file("m.gltf", tetrahedra("[{}]", r#"[{ "mesh": 0 }]"#, None));
    let cases: &[(&[&str], &[&str])] = &[
        (&["render", "a.gltf", "-o", "a.png", "--samples", "3"], &["'--spp'", "nephrite render --help"]),
        (&["render", "a.gltf", "-o", "a.png", "--hdri=x.hdr"], &["'--env'"]),
        (&["render", "a.gltf", "-o", "a.png", "--max_depth", "3"], &["'--max-depth'"]),
        (&["render", "a.gltf", "-o", "a.png", "-spp", "3"], &["'--spp'"]),
        (&["render", "a.gltf", "-o", "a.png", "--light-intensity", "3"], &["'--light-scale'"]),
        (&["render", "--input", "a.gltf", "-o", "a.png"], &["nephrite render FILE.glb"]),
        (&["profile", "--samples", "9", "--medium", "marble", "-o", "a.csv"], &["'--paths'"]),
        (&["profile", "marble", "-o", "a.csv"], &["--medium marble"]),
        (&["edit", "m.gltf", "b.gltf", "--material", "0", "--preset", "marble"], &["-o b.gltf"]),
        (&["edit", "m.gltf", "-o", "b.gltf", "--sigma-a", "3"], &["'--absorption'"]),
        (&["inspect", "a.gltf", "m.gltf"], &["all in a folder", "nephrite inspect --help"]),
        (&["a.gltf"], &["nephrite render a.gltf -o FILE.png"]),
        (&["info", "a.gltf"], &["'inspect'"]),
        (&["render", "a.gltf", "-o", "a.png", "--spp", "-1"], &["'-1'", "--spp"]),
        (&["render", "a.gltf", "-o", "a.png", "--env", "-1,0,0"], &["at least 0"]),
        (&["render", "a.gltf", "-o", "a.png", "--weld-tolerance", "1mm"], &["without \"mm\""]),
        (&["render", "a.gltf", "-o", "a.png", "--at", "2s"], &["without \"s\""]),
        (&["profile", "-o", "a.csv", "--medium", "-1,2,0,1.3"], &["σa and σs"]),
        (&["render", "a.gltf", "a.png"], &["-o a.png", "nephrite render --help"]),
        (&["render", "a.gltf", "-o", "a.png", "-o", "a.png"], &["nephrite render --help"]),
        (&["render", "a.gltf", "-o", "a.png", "--size", "640"], &["640 is one side", "1280x720"]),
        (&["render", "a.gltf", "-o", "a.png", "--env-intensity", "-1"], &["at least 0"]),
        (&["edit", "m.gltf", "-o", "b.gltf", "--absorption", "-3"], &["at least 0"]),
        (&["edit", "m.gltf", "-o", "b.gltf", "--absorption", "-3,1,1"], &["at least 0"]),
        (&["edit", "m.gltf", "-o", "b.gltf", "--density", "-1"], &["at least 0"]),
        (&["edit", "m.gltf", "-o", "b.gltf", "--mean-free-path", "1mm"], &["--unit mm"]),
        (&["edit", "m.gltf", "-o", "b.gltf", "--unit", "inch"], &["known: cm, m, mm"]),
        (&["edit", "m.gltf", "-o", "b.gltf", "--color", "#12"], &["#rrggbb"]),
        (&["profile", "-o", "a.csv", "--medium", "1,x,2,0,1.3"], &["\"x\" is no number"]),
    ];
    for (args, texts) in cases {
        sandbox.run(args).exits(2).says(texts);
    }
    let edit = ["edit", "m.gltf", "-o", "b.gltf", "--material", "0", "--unit", "cm"];
    let hex = ["--color", "#3fa060", "--mean-free-path", "0.1"];
    sandbox.run(&[&edit[..], &hex].concat()).exits(0);
    // What `edit` writes for other viewers is nothing to talk about, what says something else is.
    let render = ["render", "b.gltf", "-o", "b.png", "--size", "4x4", "--spp", "1"];
    let run = sandbox.run(&render).exits(0);
    run.check(!run.stderr.contains("other medium"), "should not tell of its own fallback");
    let change = ["edit", "c.gltf", "-o", "d.gltf", "--material", "0", "--no-fallback", "--scattering", "7"];
    sandbox.run(&["edit", "m.gltf", "-o", "c.gltf", "--material", "0", "--preset", "marble"]).exits(0);
    sandbox.run(&change).exits(0);
    sandbox
        .run(&["render", "d.gltf", "-o", "d.png", "--size", "4x4", "--spp", "1"])
        .exits(0)
        .says(&["other medium"]);
    let run = sandbox.run(&["render", "--help"]).exits(0);
    for model in ["random-walk", "accelerated-walk", "better-dipole"] {
        run.check(run.stdout.contains(model), model);
    }
}

#[test]
fn strict_fails_on_images_that_are_not_there() {
    let sandbox = Sandbox::new();
    let textured = |uri: &str| {
        triangle(&format!(
            r#""images": [{{ "uri": "{uri}" }}], "textures": [{{ "source": 0 }}],
            "materials": [{{ "pbrMetallicRoughness": {{ "baseColorTexture": {{ "index": 0 }} }} }}],"#
        ))
        .replace(r#""POSITION": 0 } }"#, r#""POSITION": 0 }, "material": 0 }"#)
    };
    sandbox.file("missing.gltf", textured("no.png"));
    sandbox.file("broken.gltf", textured("broken.png"));
    sandbox.file("broken.png", "\u{89}PNG no more");
    for name in ["missing.gltf", "broken.gltf"] {
        let args = ["render", name, "-o", "a.png", "--size", "4x4", "--spp", "1"];
        sandbox.run(&args).exits(0).says(&["warning:", "left out"]);
        sandbox.run(&[&args[..], &["--strict"]].concat()).exits(1).says(&["error:", "/images/0"]);
    }
}

#[test]
fn one_is_not_many() {
    let sandbox = Sandbox::new();
    sandbox.file("a.gltf", triangle(""));
    let args = ["render", "a.gltf", "-o", "a.png", "--size", "4x4", "--spp", "1"];
    sandbox.run(&args).exits(0).says(&["1 sample a pixel"]);
}

/// Two tetrahedra that blue light crosses undimmed, and so comes out of where a face is missing.
#[test]
fn leaks_are_told_of_open_meshes_and_of_nothing_else() {
    let sandbox = Sandbox::new();
    let materials = r#"[{ "pbrMetallicRoughness": { "metallicFactor": 0 }, "extensions": { "NEPHRITE_materials_subsurface": {
        "absorptionCoefficient": [5, 1, 0] } } }]"#;
    let args = ["render", "a.gltf", "-o", "a.png", "--size", "24x24", "--spp", "16", "--stats", "a.json"];
    let counted = |name: &str| {
        let text = std::fs::read(sandbox.path("a.json")).unwrap();
        serde_json::from_slice::<serde_json::Value>(&text).unwrap()["counters"][name].as_u64().unwrap()
    };
    for (mesh, leaks) in [(1, true), (0, false)] {
        let nodes = format!(r#"[{{ "mesh": 0 }}, {{ "mesh": {mesh}, "translation": [2, 0, 0] }}]"#);
        sandbox.file("a.gltf", tetrahedra(materials, &nodes, None));
        let run = sandbox.run(&args).exits(0);
        run.check(run.stderr.contains("leaked out of meshes that are not closed") == leaks, "leaks");
        run.check(!run.stderr.contains("lost at boundaries"), "the closed one loses nothing");
        assert_eq!((counted("leaked_paths") > 0, counted("lost_paths")), (leaks, 0));
    }
}
