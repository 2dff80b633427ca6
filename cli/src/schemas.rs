//! JSON Schemas of the JSON output of commands, one for each command.

/// Commands and their schemas.
pub const SCHEMAS: [(&str, &str); 13] = [
    ("build", include_str!("../schemas/build.schema.json")),
    ("campaign", include_str!("../schemas/campaign.schema.json")),
    ("compare", include_str!("../schemas/compare.schema.json")),
    ("diagnose", include_str!("../schemas/diagnose.schema.json")),
    ("effects", include_str!("../schemas/effects.schema.json")),
    ("excite", include_str!("../schemas/excite.schema.json")),
    ("export", include_str!("../schemas/export.schema.json")),
    ("fit", include_str!("../schemas/fit.schema.json")),
    ("frf", include_str!("../schemas/frf.schema.json")),
    ("generate-campaign", include_str!("../schemas/generate-campaign.schema.json")),
    ("inspect", include_str!("../schemas/inspect.schema.json")),
    ("sets", include_str!("../schemas/sets.schema.json")),
    ("simulate", include_str!("../schemas/simulate.schema.json")),
];
