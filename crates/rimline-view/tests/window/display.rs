//! A display without a screen, and what a user does there.

use std::io::Read as _;
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use rimline_testkit::on_gpu::text as say;
use x11rb::connection::Connection;
use x11rb::protocol::xproto::{ConnectionExt as _, InputFocus, Window};
use x11rb::protocol::xtest::ConnectionExt as _;
use x11rb::rust_connection::RustConnection;

pub(crate) fn is_installed() -> bool {
    Command::new("Xvfb").arg("-help").stdout(Stdio::null()).stderr(Stdio::null()).status().is_ok()
}

/// Kinds of events of the core protocol.
const KEY: u8 = 2;
const BUTTON: u8 = 4;
const MOTION: u8 = 6;

pub(crate) struct Display {
    server: Child,
    pub(crate) name: String,
    connection: RustConnection,
    root: Window,
}

/// Focus that follows the pointer, of no window.
const POINTER_ROOT: u32 = 1;

impl Drop for Display {
    fn drop(&mut self) {
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}

impl Display {
    /// Starts a server with a number of its own.
    pub(crate) fn start() -> Result<Self, String> {
        let mut server = Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", "1000x700x24", "-nolisten", "tcp"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .map_err(|error| format!("Xvfb cannot be started: {error}; `cargo xtask test` installs it"))?;
        let mut number = String::new();
        let mut out = server.stdout.take().ok_or("Xvfb says nothing")?;
        let mut byte = [0];
        while out.read(&mut byte).map_err(say)? == 1 && byte[0] != b'\n' {
            number.push(char::from(byte[0]));
        }
        let name = format!(":{number}");
        let (connection, screen) = RustConnection::connect(Some(&name)).map_err(say)?;
        let root = connection.setup().roots[screen].root;
        Ok(Self { server, name, connection, root })
    }

    /// Waits for a window of the viewer.
    pub(crate) fn window(&self, within: Duration) -> Result<Window, String> {
        let until = Instant::now() + within;
        while Instant::now() < until {
            let windows = self.connection.query_tree(self.root).map_err(say)?.reply().map_err(say)?.children;
            for window in windows {
                let shape = self.connection.get_geometry(window).map_err(say)?.reply();
                let state = self.connection.get_window_attributes(window).map_err(say)?.reply();
                let is_seen = state.is_ok_and(|state| u8::from(state.map_state) == 2);
                if is_seen && shape.is_ok_and(|shape| shape.width > 300) {
                    return Ok(window);
                }
            }
            sleep(Duration::from_millis(50));
        }
        Err("no window appeared".into())
    }

    /// The pixel of the screen where a window begins.
    pub(crate) fn corner(&self, window: Window) -> Result<[i16; 2], String> {
        let shape = self.connection.get_geometry(window).map_err(say)?.reply().map_err(say)?;
        Ok([shape.x, shape.y])
    }

    pub(crate) fn title(&self, window: Window) -> Result<String, String> {
        let atom = |name: &[u8]| -> Result<_, String> {
            Ok(self.connection.intern_atom(false, name).map_err(say)?.reply().map_err(say)?.atom)
        };
        let (name, kind) = (atom(b"_NET_WM_NAME")?, atom(b"UTF8_STRING")?);
        let property = self.connection.get_property(false, window, name, kind, 0, 1000).map_err(say)?;
        Ok(String::from_utf8_lossy(&property.reply().map_err(say)?.value).into_owned())
    }

    /// Whether somebody offers a text to paste.
    pub(crate) fn has_clipboard(&self) -> Result<bool, String> {
        let atom = self.connection.intern_atom(false, b"CLIPBOARD").map_err(say)?.reply().map_err(say)?.atom;
        Ok(self.connection.get_selection_owner(atom).map_err(say)?.reply().map_err(say)?.owner != x11rb::NONE)
    }

    pub(crate) fn resize(&self, window: Window, [width, height]: [u32; 2]) -> Result<(), String> {
        let change = x11rb::protocol::xproto::ConfigureWindowAux::new().width(width).height(height);
        self.connection.configure_window(window, &change).map_err(say)?;
        self.connection.flush().map_err(say)
    }

    fn fake(&self, kind: u8, detail: u8, [x, y]: [i16; 2]) -> Result<(), String> {
        self.connection.xtest_fake_input(kind, detail, 0, self.root, x, y, 0).map_err(say)?;
        self.connection.flush().map_err(say)?;
        sleep(Duration::from_millis(30));
        Ok(())
    }

    pub(crate) fn drag(&self, from: [i16; 2], to: [i16; 2]) -> Result<(), String> {
        self.fake(MOTION, 0, from)?;
        sleep(Duration::from_millis(300));
        self.fake(BUTTON, 1, [0, 0])?;
        for step in 1..=5_i16 {
            let along = |axis: usize| from[axis] + (to[axis] - from[axis]) * step / 5;
            self.fake(MOTION, 0, [along(0), along(1)])?;
        }
        self.fake(BUTTON + 1, 1, [0, 0])
    }

    /// Gives the keyboard to a window, anew: it may not have listened before.
    fn focus(&self, window: Window) -> Result<(), String> {
        for focus in [POINTER_ROOT, window] {
            self.connection.set_input_focus(InputFocus::PARENT, focus, x11rb::CURRENT_TIME).map_err(say)?;
            self.connection.flush().map_err(say)?;
            sleep(Duration::from_millis(50));
        }
        Ok(())
    }

    /// Presses a key by its symbol, which is that of ASCII, in a window.
    pub(crate) fn press(&self, window: Window, symbol: u32) -> Result<(), String> {
        self.focus(window)?;
        let setup = self.connection.setup();
        let (first, last) = (setup.min_keycode, setup.max_keycode);
        let map = self.connection.get_keyboard_mapping(first, last - first + 1).map_err(say)?.reply().map_err(say)?;
        let width = usize::from(map.keysyms_per_keycode.max(1));
        let at = map.keysyms.chunks(width).position(|symbols| symbols.first() == Some(&symbol));
        let code = first + at.ok_or_else(|| format!("no key has the symbol {symbol}"))? as u8;
        self.fake(KEY, code, [0, 0])?;
        self.fake(KEY + 1, code, [0, 0])
    }
}
