//! Random scenes that change from frame to frame, and the results of each of their casters alone.

use std::sync::Arc;

use glam::{DMat3, DVec3};
use rimline::gpu::{
    Caster, CasterHandle, CasterPositions, FrameInputs, LightHandle, LightMask, MeshHandle, Scene, SceneFrame,
    SceneOptions,
};
use rimline::internals::cpu::{self, Threads};
use rimline::{Light, Matrix3x4, Mesh, Predicate};
use rimline_testkit::cases::{Case, case, random_soup, topologies};
use rimline_testkit::device::Gpu;
use rimline_testkit::on_gpu::{interleaved, text};
use rimline_testkit::oracle::listed;
use rimline_testkit::random::Random;
use rimline_testkit::scenes::direction;
use rimline_testkit::shapes::{self, Shape};

use crate::cones::random_cone;

/// A caster of the test.
#[derive(Clone)]
pub(crate) struct TestCaster {
    pub(crate) handle: CasterHandle,
    pub(crate) mesh: usize,
    /// The transform of a rigid caster, or the positions in world space.
    pub(crate) placed: Placed,
    pub(crate) lights: LightMask,
    pub(crate) in_depth: bool,
    /// The stated box of positions in a buffer.
    pub(crate) bounds: Option<[[f32; 3]; 2]>,
}

#[derive(Clone)]
pub(crate) enum Placed {
    Rigid(Matrix3x4),
    World(Vec<[f32; 3]>),
}

/// A scene, and a plain list of its content.
pub(crate) struct RandomScene {
    pub(crate) random: Random,
    pub(crate) scene: Scene,
    pub(crate) content: Content,
}

/// The content of a scene at one time.
#[derive(Clone)]
pub(crate) struct Content {
    pub(crate) meshes: Vec<(Arc<Case>, MeshHandle)>,
    pub(crate) casters: Vec<TestCaster>,
    pub(crate) lights: Vec<(LightHandle, Light)>,
}

/// Expected results of one caster: facing masks for each batch, and silhouette edges for each bit, in order.
pub(crate) struct Expected {
    pub(crate) facing: Vec<Vec<u32>>,
    pub(crate) lists: Vec<Vec<u32>>,
    /// Lights in the planes of faces.
    pub(crate) excluded: Vec<Vec<u32>>,
}

/// An encoder that a test submits late, or drops.
pub(crate) fn encoder(gpu: &Gpu) -> wgpu::CommandEncoder {
    gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default())
}

fn meshes(random: &mut Random) -> Vec<Case> {
    let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.25]];
    let mut torus = shapes::torus(12, 9, 1.0, 0.4);
    torus.positions[1][2] = f32::NAN;
    torus.positions[5][0] = f32::INFINITY;
    let mut cases = topologies();
    cases.extend([
        case("one face", Shape { positions, faces: vec![[0, 1, 2]] }),
        case("cube", shapes::cube()),
        case("torus with NaN", torus),
        case("soup", random_soup(random)),
    ]);
    cases
}

impl RandomScene {
    fn new(gpu: &Gpu, seed: u64, options: SceneOptions) -> Result<Self, String> {
        let mut random = Random::new(seed);
        let mut scene = Scene::new(&gpu.pipelines, &gpu.queue, options).map_err(text)?;
        let mut meshes = meshes(&mut random);
        random.shuffle(&mut meshes);
        meshes.truncate(2 + random.below(5));
        let add = |case: Case| {
            let handle = scene.add_mesh(&case.2, &case.1).map_err(text)?;
            Ok::<_, String>((Arc::new(case), handle))
        };
        let meshes = meshes.into_iter().map(add).collect::<Result<_, _>>()?;
        Ok(Self { random, scene, content: Content { meshes, casters: Vec::new(), lights: Vec::new() } })
    }

    /// A scene with these numbers of lights and casters.
    pub(crate) fn filled(gpu: &Gpu, seed: u64, options: SceneOptions, counts: [usize; 2]) -> Result<Self, String> {
        let mut scene = Self::filled_rigid(gpu, seed, options, [counts[0], 0])?;
        (0..counts[1]).try_for_each(|_| scene.insert(gpu))?;
        Ok(scene)
    }

    /// The same with rigid casters.
    pub(crate) fn filled_rigid(
        gpu: &Gpu,
        seed: u64,
        options: SceneOptions,
        counts: [usize; 2],
    ) -> Result<Self, String> {
        println!("seed {seed}");
        let mut scene = Self::new(gpu, seed, options)?;
        (0..counts[0]).try_for_each(|_| scene.add_light())?;
        (0..counts[1]).try_for_each(|_| scene.insert_rigid())?;
        Ok(scene)
    }

    /// Rotations, mirrored, scales of 1e-3 to 1e3, translations up to 1e6; now and then singular or not finite.
    fn transform(&mut self) -> Matrix3x4 {
        let random = &mut self.random;
        let turn = DMat3::from_axis_angle(direction(random), f64::from(random.between(-3.0, 3.0)));
        let scale = |random: &mut Random| {
            let sign = if random.below(4) == 0 { -1.0 } else { 1.0 };
            sign * 10.0_f64.powf(f64::from(random.between(-3.0, 3.0)))
        };
        let scales = match random.below(4) {
            0 => DVec3::new(scale(random), scale(random), scale(random)),
            1 => DVec3::ONE,
            _ => DVec3::splat(scale(random)),
        };
        let far = [0.0, 3.0, 50.0, 1e6][random.below(4)];
        let translation = DVec3::from([(); 3].map(|()| f64::from(random.between(-far, far))));
        let matrix = turn * DMat3::from_diagonal(scales);
        let mut rows: Matrix3x4 =
            std::array::from_fn(|row| matrix.row(row).extend(translation[row]).as_vec4().to_array());
        match random.below(16) {
            0 => rows[random.below(3)] = [0.0; 4],
            1 => rows[1][random.below(4)] = f32::NAN,
            _ => {}
        }
        rows
    }

    fn light(&mut self) -> Light {
        let random = &mut self.random;
        let far = [2.0, 10.0, 100.0, 1e6][random.below(4)];
        let xyz = [(); 3].map(|()| random.between(-far, far));
        let mut light = match random.below(4) {
            0 => Light::directional(random.direction()),
            1 => {
                let w = random.between(0.2, 3.0);
                Light::homogeneous([xyz[0] * w, xyz[1] * w, xyz[2] * w, w])
            }
            // In the planes of faces of casters that are not turned.
            2 => Light::point([xyz[0], 0.0, 0.0]),
            _ => Light::point(xyz),
        };
        light.cone = (random.below(3) == 0).then(|| random_cone(random));
        if random.below(2) == 0 { light.with_range(far * random.between(0.01, 2.0)) } else { light }
    }

    fn mask(&mut self) -> LightMask {
        match self.random.below(3) {
            0 => LightMask::ALL,
            1 => LightMask::only(
                self.content.lights.iter().map(|(handle, _)| *handle).filter(|_| self.random.below(2) == 0),
            ),
            _ => self.content.lights.first().map_or(LightMask::ALL, |(handle, _)| LightMask::ALL.without(*handle)),
        }
    }

    /// A caster of any mesh: as a rule a rigid one.
    pub(crate) fn insert(&mut self, gpu: &Gpu) -> Result<(), String> {
        if self.random.below(4) > 0 {
            return self.insert_rigid();
        }
        let mesh = self.random.below(self.content.meshes.len());
        let transform = self.transform();
        let rest = &self.content.meshes[mesh].0.1;
        let world: Vec<_> = rest.iter().map(|&position| moved(&transform, position)).collect();
        let (offset, stride) = ([0, 8, 260][self.random.below(3)], [12, 16, 28][self.random.below(3)]);
        let buffer = gpu.storage(&interleaved(&world, offset, stride));
        let ends = |pick: fn(f32, f32) -> f32, first: f32| {
            let finite = world.iter().filter(|position| position.iter().all(|c| c.is_finite()));
            finite.fold([first; 3], |end, position| std::array::from_fn(|axis| pick(end[axis], position[axis])))
        };
        let bounds = [ends(f32::min, f32::INFINITY), ends(f32::max, f32::NEG_INFINITY)];
        let handle = self.insert_as(mesh, Placed::World(world), CasterPositions::Buffer { buffer, offset, stride })?;
        // Half of the casters have a stated box that holds their positions.
        if bounds[0][0].is_finite() && self.content.casters.len().is_multiple_of(2) {
            self.scene.set_bounds(handle, Some(bounds)).map_err(text)?;
            if let Some(caster) = self.content.casters.last_mut() {
                caster.bounds = Some(bounds);
            }
        }
        Ok(())
    }

    pub(crate) fn insert_rigid(&mut self) -> Result<(), String> {
        let mesh = self.random.below(self.content.meshes.len());
        self.insert_rigid_of(mesh)
    }

    pub(crate) fn insert_rigid_of(&mut self, mesh: usize) -> Result<(), String> {
        let transform = self.transform();
        self.insert_at(mesh, transform).map(drop)
    }

    pub(crate) fn insert_at(&mut self, mesh: usize, rows: Matrix3x4) -> Result<CasterHandle, String> {
        self.insert_as(mesh, Placed::Rigid(rows), CasterPositions::Rigid(rows.into()))
    }

    /// Adds a mesh. Returns its index.
    pub(crate) fn add_mesh(&mut self, name: &str, shape: Shape) -> Result<usize, String> {
        let case = case(name, shape);
        let handle = self.scene.add_mesh(&case.2, &case.1).map_err(text)?;
        self.content.meshes.push((Arc::new(case), handle));
        Ok(self.content.meshes.len() - 1)
    }

    pub(crate) fn insert_as(
        &mut self,
        mesh: usize,
        placed: Placed,
        positions: CasterPositions,
    ) -> Result<CasterHandle, String> {
        let lights = self.mask();
        let in_depth = self.random.below(2) == 0;
        let caster = Caster { mesh: self.content.meshes[mesh].1, positions, lights, in_depth };
        let handle = self.scene.insert(caster).map_err(text)?;
        self.content.casters.push(TestCaster { handle, mesh, placed, lights, in_depth, bounds: None });
        Ok(handle)
    }

    pub(crate) fn add_light(&mut self) -> Result<(), String> {
        let light = self.light();
        self.put_light(light)
    }

    pub(crate) fn put_light(&mut self, light: Light) -> Result<(), String> {
        let handle = self.scene.add_light(light).map_err(text)?;
        self.content.lights.push((handle, light));
        Ok(())
    }

    pub(crate) fn remove_caster(&mut self, index: usize) -> Result<(), String> {
        let caster = self.content.casters.swap_remove(index);
        self.scene.remove(caster.handle).map_err(text)
    }

    /// Changes a few things, as a game would between frames.
    pub(crate) fn change(&mut self, gpu: &Gpu) -> Result<(), String> {
        for _ in 0..=self.random.below(3) {
            let (caster, light) =
                (self.random.below(self.content.casters.len()), self.random.below(self.content.lights.len()));
            match self.random.below(8) {
                0 if !self.content.casters.is_empty() => self.remove_caster(caster)?,
                1 => self.insert(gpu)?,
                2 if !self.content.lights.is_empty() => {
                    let (handle, _) = self.content.lights.swap_remove(light);
                    self.scene.remove_light(handle).map_err(text)?;
                }
                3 if self.content.lights.len() < 40 => self.add_light()?,
                4 if !self.content.lights.is_empty() => {
                    let moved = self.light();
                    self.set_light(light, moved)?;
                }
                5 if !self.content.casters.is_empty() => {
                    let mask = self.mask();
                    self.content.casters[caster].lights = mask;
                    self.scene.set_lights(self.content.casters[caster].handle, mask).map_err(text)?;
                }
                _ => drop(self.move_casters()?),
            }
        }
        Ok(())
    }

    pub(crate) fn set_light(&mut self, index: usize, light: Light) -> Result<(), String> {
        self.content.lights[index].1 = light;
        self.scene.set_light(self.content.lights[index].0, light).map_err(text)
    }

    /// Changes some lights. Returns their bits.
    pub(crate) fn move_lights(&mut self) -> Result<Vec<u32>, String> {
        let mut moved = Vec::new();
        for index in 0..self.content.lights.len() {
            if self.random.below(4) == 0 {
                let light = self.light();
                self.set_light(index, light)?;
                moved.push(self.content.lights[index].0.bit());
            }
        }
        Ok(moved)
    }

    /// All casters have all lights.
    pub(crate) fn set_all_lights(&mut self) -> Result<(), String> {
        for caster in &mut self.content.casters {
            caster.lights = LightMask::ALL;
            self.scene.set_lights(caster.handle, LightMask::ALL).map_err(text)?;
        }
        Ok(())
    }

    /// Moves some rigid casters. Returns them.
    pub(crate) fn move_casters(&mut self) -> Result<Vec<CasterHandle>, String> {
        let mut moved = Vec::new();
        for index in 0..self.content.casters.len() {
            if matches!(self.content.casters[index].placed, Placed::Rigid(_)) && self.random.below(3) == 0 {
                let transform = self.transform();
                let caster = &mut self.content.casters[index];
                caster.placed = Placed::Rigid(transform);
                self.scene.set_transform(caster.handle, transform).map_err(text)?;
                moved.push(caster.handle);
            }
        }
        Ok(moved)
    }

    pub(crate) fn encode(&mut self, encoder: &mut wgpu::CommandEncoder) -> Result<SceneFrame, String> {
        self.scene.encode(encoder, FrameInputs::default()).map_err(text)
    }
}

impl Content {
    /// The light of a bit in the space of a caster, unless the mask or the space has none.
    pub(crate) fn moved_light(&self, caster: &TestCaster, bit: u32) -> Option<Light> {
        let (handle, light) = self.lights.iter().find(|(handle, _)| handle.bit() == bit)?;
        caster.lights.contains(*handle).then_some(())?;
        match &caster.placed {
            Placed::World(_) => Some(*light),
            Placed::Rigid(rows) => {
                let columns: [[f64; 3]; 4] = std::array::from_fn(|column| rows.map(|row| f64::from(row[column])));
                light.to_mesh_space(&columns).filter(|light| light.to_array() != [0.0; 4])
            }
        }
    }

    /// A caster's mesh, and its positions in the space of its lights.
    pub(crate) fn mesh_and_positions<'a>(&'a self, caster: &'a TestCaster) -> (&'a Mesh, &'a [[f32; 3]]) {
        let (case, _) = &self.meshes[caster.mesh];
        let (_, rest, mesh) = &**case;
        (mesh, if let Placed::World(world) = &caster.placed { world } else { rest })
    }

    /// Results of a caster alone, for its relevant lights, a word for each batch.
    pub(crate) fn alone(&self, caster: &TestCaster, relevant: &[u32]) -> Result<Expected, String> {
        let (mesh, positions) = self.mesh_and_positions(caster);
        let mut expected = Expected { facing: Vec::new(), lists: Vec::new(), excluded: Vec::new() };
        for (batch, relevant) in (0..).zip(relevant) {
            let bits: Vec<u32> = (0..32).filter(|bit| relevant >> bit & 1 != 0).collect();
            let lights = bits.iter().map(|bit| self.moved_light(caster, 32 * batch + bit));
            let lights: Vec<Light> = lights.collect::<Option<_>>().ok_or("a relevant light is not allowed")?;
            let found = extract(positions, mesh, &lights)?;
            let spread = |mask: u32| bits.iter().zip(0..).fold(0, |all, (bit, index)| all | (mask >> index & 1) << bit);
            expected.facing.push(found.facing.iter().copied().map(spread).collect());
            let excluded = cpu::excluded(positions, mesh.faces(), &lights);
            expected.excluded.push(excluded.into_iter().map(spread).collect());
            for bit in 0..32 {
                let index = bits.iter().position(|&other| other == bit);
                let list = index.map(|index| listed(&found.masks, index as u32));
                expected.lists.push(list.unwrap_or_default());
            }
        }
        Ok(expected)
    }
}

fn extract(positions: &[[f32; 3]], mesh: &Mesh, lights: &[Light]) -> Result<cpu::Extraction, String> {
    if lights.is_empty() {
        // The CPU's masks have no plane then.
        return Ok(cpu::Extraction { facing: vec![0; mesh.faces().len()], ..Default::default() });
    }
    cpu::extract(positions, mesh, lights, Predicate::Exact, Threads::ONE).map_err(text)
}

fn moved(rows: &Matrix3x4, [x, y, z]: [f32; 3]) -> [f32; 3] {
    rows.map(|[a, b, c, d]| a * x + b * y + c * z + d)
}
