//! The keyboard.

/// A command of the viewer, by a key or a button.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
#[expect(missing_docs, reason = "`KEYS` has a description of each")]
pub enum Action {
    Help,
    Panel,
    OpenFile,
    NextScene,
    ResetCamera,
    NextCamera,
    TurnLeft,
    TurnRight,
    TurnUp,
    TurnDown,
    Nearer,
    Farther,
    Play,
    StepBack,
    StepOn,
    Slower,
    Faster,
    NextAnimation,
    NextLight,
    AddLight,
    RemoveLight,
    SwitchLight,
    ChangeLightKind,
    LightLeft,
    LightRight,
    LightUp,
    LightDown,
    LightAhead,
    LightBack,
    Silhouettes,
    LightSilhouettes,
    Volumes,
    Caps,
    Boundary,
    NonManifold,
    Creases,
    Exact,
    Clusters,
    Receivers,
    Boxes,
    Ground,
    Shadows,
    Smooth,
    Colors,
    NextMode,
    NextCounting,
    Screenshot,
    LargeScreenshot,
    CopyCommand,
    Close,
}

impl Action {
    /// Whether it goes a step on, again and again while its key is held.
    pub(crate) fn is_gradual(self) -> bool {
        use Action as A;
        let turns = matches!(self, A::TurnLeft | A::TurnRight | A::TurnUp | A::TurnDown | A::Nearer | A::Farther);
        let moves_light =
            matches!(self, A::LightLeft | A::LightRight | A::LightUp | A::LightDown | A::LightAhead | A::LightBack);
        turns || moves_light || matches!(self, A::StepBack | A::StepOn)
    }
}

/// A key and what it does.
#[derive(Clone, Copy, Debug)]
pub struct KeyBinding {
    /// The key as [`egui::Key`] has it.
    pub key: egui::Key,
    /// Whether Shift is held.
    pub shift: bool,
    /// Its effect.
    pub action: Action,
    /// The same in words.
    pub what: &'static str,
}

const fn key(key: egui::Key, action: Action, what: &'static str) -> KeyBinding {
    KeyBinding { key, shift: false, action, what }
}

const fn shift(key: egui::Key, action: Action, what: &'static str) -> KeyBinding {
    KeyBinding { key, shift: true, action, what }
}

/// All keys but W, A, S, D, Q and E, which fly while they are held, and Tab, which moves the keyboard on to the next widget of
/// the panel, until Escape: so everything there needs no pointer.
pub const KEYS: [KeyBinding; 50] = {
    use egui::Key as K;
    [
        key(K::F1, Action::Help, "this list; ? too"),
        key(K::U, Action::Panel, "show or hide the panel"),
        key(K::O, Action::OpenFile, "open files"),
        key(K::N, Action::NextScene, "next scene: built-in ones, your files"),
        key(K::R, Action::ResetCamera, "show everything"),
        key(K::V, Action::NextCamera, "next camera of the files"),
        key(K::ArrowLeft, Action::TurnLeft, "turn left"),
        key(K::ArrowRight, Action::TurnRight, "turn right"),
        key(K::ArrowUp, Action::TurnUp, "turn up"),
        key(K::ArrowDown, Action::TurnDown, "turn down"),
        key(K::Plus, Action::Nearer, "nearer"),
        key(K::Minus, Action::Farther, "farther"),
        key(K::Space, Action::Play, "play or stop"),
        key(K::Comma, Action::StepBack, "a thirtieth of a second back"),
        key(K::Period, Action::StepOn, "a thirtieth of a second on"),
        key(K::OpenBracket, Action::Slower, "slower"),
        key(K::CloseBracket, Action::Faster, "faster"),
        shift(K::N, Action::NextAnimation, "next animation"),
        key(K::L, Action::NextLight, "select the next light"),
        key(K::Insert, Action::AddLight, "add a light"),
        key(K::Delete, Action::RemoveLight, "remove the selected light"),
        key(K::T, Action::SwitchLight, "switch the selected light on or off"),
        key(K::I, Action::ChangeLightKind, "light at a point or at infinity"),
        shift(K::ArrowLeft, Action::LightLeft, "move the light left"),
        shift(K::ArrowRight, Action::LightRight, "move the light right"),
        key(K::PageUp, Action::LightUp, "move the light up"),
        key(K::PageDown, Action::LightDown, "move the light down"),
        shift(K::ArrowUp, Action::LightAhead, "move the light away"),
        shift(K::ArrowDown, Action::LightBack, "move the light nearer"),
        key(K::Num1, Action::Silhouettes, "silhouettes as you see them"),
        key(K::Num2, Action::LightSilhouettes, "silhouettes as lights see them"),
        key(K::Num3, Action::Volumes, "shadow volumes"),
        key(K::Num4, Action::Caps, "light caps"),
        key(K::Num5, Action::Boundary, "boundary edges"),
        key(K::Num6, Action::NonManifold, "non-manifold edges"),
        key(K::Num7, Action::Creases, "creases"),
        key(K::Num8, Action::Exact, "faces decided in exact arithmetic"),
        key(K::Num9, Action::Boxes, "boxes"),
        key(K::Num0, Action::Clusters, "clusters of faces"),
        key(K::Z, Action::Receivers, "depths of receivers"),
        key(K::G, Action::Ground, "ground"),
        key(K::H, Action::Shadows, "shadows"),
        key(K::F, Action::Smooth, "smooth or flat faces"),
        key(K::B, Action::Colors, "base colours or clay"),
        key(K::M, Action::NextMode, "next way to draw shadows"),
        key(K::K, Action::NextCounting, "next counting method"),
        key(K::P, Action::Screenshot, "screenshot"),
        shift(K::P, Action::LargeScreenshot, "screenshot, four times as large"),
        key(K::C, Action::CopyCommand, "copy this view as a command"),
        key(K::Escape, Action::Close, "close this list, or the window"),
    ]
};

/// The action of a key that was pressed.
pub(crate) fn action(pressed: egui::Key, shift: bool) -> Option<Action> {
    let is_help = pressed == egui::Key::Questionmark || pressed == egui::Key::Slash && shift;
    if is_help {
        return Some(Action::Help);
    }
    let pressed = if pressed == egui::Key::Equals { egui::Key::Plus } else { pressed };
    // Some keyboards have these on Shift.
    let shift = shift && !matches!(pressed, egui::Key::Plus | egui::Key::OpenBracket | egui::Key::CloseBracket);
    KEYS.iter().find(|binding| binding.key == pressed && binding.shift == shift).map(|binding| binding.action)
}

/// The key of an action, for hints.
pub(crate) fn key_of(action: Action) -> String {
    KEYS.iter().find(|binding| binding.action == action).map_or_else(String::new, KeyBinding::name)
}

/// The effect of an action, and its key.
pub(crate) fn hint(action: Action) -> String {
    let of = |binding: &KeyBinding| format!("{} ({})", binding.what, binding.name());
    KEYS.iter().find(|binding| binding.action == action).map_or_else(String::new, of)
}

impl KeyBinding {
    /// The key in words.
    pub fn name(&self) -> String {
        use egui::Key as K;
        let key = match self.key {
            // The fonts lack egui's symbols of arrows.
            K::ArrowLeft | K::ArrowRight | K::ArrowUp | K::ArrowDown => self.key.name(),
            key => key.symbol_or_name(),
        };
        if self.shift { format!("Shift {key}") } else { key.to_owned() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fonts_have_the_names_of_all_keys() {
        let context = egui::Context::default();
        let mut output = context.run_ui(egui::RawInput::default(), |_| {});
        // egui panics where textures that were never painted are dropped.
        output.textures_delta.clear();
        for binding in &KEYS {
            let name = binding.name();
            let is_drawn = context.fonts_mut(|fonts| fonts.has_glyphs(&egui::FontId::default(), &name));
            assert!(is_drawn, "{name}: {}", binding.what);
        }
    }

    #[test]
    fn keys_that_the_panel_needs_are_left_to_it() {
        for shift in [false, true] {
            assert_eq!([egui::Key::Tab, egui::Key::Enter].map(|key| action(key, shift)), [None; 2]);
        }
    }

    #[test]
    fn no_key_has_two_meanings() {
        for (number, binding) in KEYS.iter().enumerate() {
            assert_eq!(action(binding.key, binding.shift), Some(binding.action), "{}", binding.what);
            let others = KEYS.iter().skip(number + 1);
            assert!(others.clone().all(|other| other.action != binding.action), "{}", binding.what);
        }
    }
}
