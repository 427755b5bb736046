//! The time of animations.

/// The time that models are shown at, in seconds, and whether it runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clock {
    /// Seconds from the start of the animations.
    pub seconds: f32,
    /// Whether it runs.
    pub is_running: bool,
    /// Seconds of the animation for each second. Negative: backwards.
    pub speed: f32,
}

impl Default for Clock {
    /// At the start, running.
    fn default() -> Self {
        Self { seconds: 0.0, is_running: true, speed: 1.0 }
    }
}

impl Clock {
    /// Goes on by seconds of the wall clock. After `duration` it starts again.
    pub fn advance(&mut self, seconds: f32, duration: f32) {
        if self.is_running && duration > 0.0 {
            self.seconds = (self.seconds + seconds * self.speed).rem_euclid(duration);
        }
    }

    /// Goes faster or slower by a factor, the same way as before: an eighth to eight times as fast as the animation.
    pub(super) fn change_speed(&mut self, factor: f32) {
        self.speed = (self.speed.abs() * factor).clamp(0.125, 8.0).copysign(self.speed);
    }
}

#[cfg(test)]
mod tests {
    use super::Clock;

    #[test]
    fn time_starts_again_both_ways() {
        let mut clock = Clock { seconds: 0.9, ..Clock::default() };
        clock.advance(0.3, 1.0);
        assert!((clock.seconds - 0.2).abs() < 1e-6);
        clock.speed = -2.0;
        clock.advance(0.3, 1.0);
        assert!((clock.seconds - 0.6).abs() < 1e-6);
        clock.is_running = false;
        clock.advance(5.0, 1.0);
        assert!((clock.seconds - 0.6).abs() < 1e-6);
    }

    #[test]
    fn a_change_of_speed_keeps_the_direction() {
        for speed in [1.0, -1.0] {
            let mut clock = Clock { speed, ..Clock::default() };
            (0..9).for_each(|_| clock.change_speed(2.0));
            assert_eq!(clock.speed, 8.0 * speed);
            (0..9).for_each(|_| clock.change_speed(0.5));
            assert_eq!(clock.speed, 0.125 * speed);
        }
        let mut still = Clock { speed: 0.0, ..Clock::default() };
        still.change_speed(2.0);
        assert_eq!(still.speed, 0.125);
    }
}
