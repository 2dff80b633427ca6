//! Selectors of a set and of its transfer function: surface, stage of wear, load case, order.

use serde::Deserialize;

/// Defines an enumeration with its names, so that files, the FMU and the command line spell it alike.
macro_rules! named {
    ($(#[$doc:meta])* $name:ident { $($(#[$item_doc:meta])* $item:ident = $text:literal / $short:literal),+ $(,)? }) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Deserialize)]
        #[serde(rename_all = "snake_case")]
        pub enum $name { $($(#[$item_doc])* $item),+ }

        impl $name {
            /// All of them, in their order.
            pub const ALL: &'static [Self] = &[$(Self::$item),+];
            /// Their names, in their order.
            pub const NAMES: &'static [&'static str] = &[$($text),+];

            /// The name in full.
            #[must_use]
            pub fn name(self) -> &'static str {
                match self { $(Self::$item => $text),+ }
            }

            /// The form used in set names.
            #[must_use]
            pub fn short(self) -> &'static str {
                match self { $(Self::$item => $short),+ }
            }
        }
    };
}

named! {
    /// Control surface.
    Surface {
        /// Trailing edge, driven by a rotary vane actuator.
        TrailingEdge = "trailing_edge" / "te",
        /// Upper spoiler, driven by a piston actuator.
        UpperSpoiler = "upper_spoiler" / "us",
        /// Lower spoiler, driven by a piston actuator.
        LowerSpoiler = "lower_spoiler" / "ls",
    }
}

named! {
    /// Stage of the wind-tunnel test, i.e. of wear.
    Stage {
        /// First week.
        Early = "early" / "early",
        /// Second week.
        Middle = "middle" / "middle",
        /// Third week.
        Late = "late" / "late",
    }
}

named! {
    /// Aerodynamic load case.
    LoadCase {
        /// Wind off.
        Unloaded = "unloaded" / "unloaded",
        /// Mach 0.63 to 0.91, 74 to 190 psf.
        Loaded = "loaded" / "loaded",
    }
}

named! {
    /// Order of the transfer function.
    Order {
        /// Eq. (6): k ω² / (s² + 2ζω s + ω²).
        Second = "second" / "2",
        /// Eq. (1): k p ω² / ((s + p)(s² + 2ζω s + ω²)).
        Third = "third" / "3",
    }
}
