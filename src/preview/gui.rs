//! Drawing the window: its surface, and egui on the renderer's device.

use std::sync::Arc;

use egui_wgpu::{RendererOptions, ScreenDescriptor};
use winit::dpi::LogicalSize;
use winit::event_loop::ActiveEventLoop;
use winit::window::Window;

use super::{Settings, panel};
use crate::device::Context;
use crate::preview::PreviewError;

/// See the module.
pub struct Gui {
    pub window: Arc<Window>,
    surface: wgpu::Surface<'static>,
    config: wgpu::SurfaceConfiguration,
    pub context: egui::Context,
    pub input: egui_winit::State,
    renderer: egui_wgpu::Renderer,
}

impl Gui {
    pub fn new(
        events: &ActiveEventLoop,
        context: &Context,
        settings: &Settings,
    ) -> Result<Self, PreviewError> {
        let fail = |message: String| PreviewError::Window { message };
        let [width, height] = [settings.options.view.width, settings.options.view.height].map(f64::from);
        // As large as the picture, within what desktops have.
        let scale = (900.0 / width).min(700.0 / height).max(480.0 / width);
        let size = LogicalSize::new(width * scale + f64::from(panel::WIDTH), (height * scale).max(560.0));
        let attributes = Window::default_attributes()
            .with_title(format!("{} - Halfway", settings.title))
            .with_inner_size(size);
        let window = Arc::new(events.create_window(attributes).map_err(|error| fail(error.to_string()))?);
        let surface = context.instance.create_surface(window.clone()).map_err(|e| fail(e.to_string()))?;
        let pixels = window.inner_size();
        let mut config = surface
            .get_default_config(&context.adapter, pixels.width.max(1), pixels.height.max(1))
            .ok_or_else(|| fail(format!("{} cannot draw into windows of this desktop", context.info.name)))?;
        // The interface's colours are sRGB already.
        let formats = surface.get_capabilities(&context.adapter).formats;
        let plain = [wgpu::TextureFormat::Bgra8Unorm, wgpu::TextureFormat::Rgba8Unorm];
        if let Some(format) = plain.into_iter().find(|format| formats.contains(format)) {
            config.format = format;
        }
        config.present_mode = wgpu::PresentMode::AutoVsync;
        surface.configure(&context.device, &config);
        let renderer = egui_wgpu::Renderer::new(&context.device, config.format, RendererOptions::default());
        let gui = egui::Context::default();
        gui.set_theme(egui::Theme::Dark);
        let most = context.device.limits().max_texture_dimension_2d as usize;
        let id = egui::ViewportId::ROOT;
        let scale = Some(window.scale_factor() as f32);
        let input = egui_winit::State::new(gui.clone(), id, &window, scale, None, Some(most));
        Ok(Self { window, surface, config, context: gui, input, renderer })
    }

    pub fn resize(&mut self, context: &Context, width: u32, height: u32) {
        if width > 0 && height > 0 && [width, height] != [self.config.width, self.config.height] {
            (self.config.width, self.config.height) = (width, height);
            self.surface.configure(&context.device, &self.config);
        }
    }

    /// Draws what the interface made.
    pub fn paint(&mut self, context: &Context, mut output: egui::FullOutput) {
        use wgpu::CurrentSurfaceTexture as Current;
        let jobs = self.context.tessellate(output.shapes, output.pixels_per_point);
        for (id, deltas) in &output.textures_delta.set {
            for delta in deltas {
                self.renderer.update_texture(&context.device, &context.queue, *id, delta);
            }
        }
        let frame = match self.surface.get_current_texture() {
            Current::Success(frame) | Current::Suboptimal(frame) => Some(frame),
            Current::Outdated => {
                self.surface.configure(&context.device, &self.config);
                self.window.request_redraw();
                None
            }
            // A lost device is the worker's to report.
            Current::Timeout | Current::Occluded | Current::Lost | Current::Validation => None,
        };
        if let Some(frame) = frame {
            let view = frame.texture.create_view(&Default::default());
            let mut encoder = context.device.create_command_encoder(&Default::default());
            let screen = ScreenDescriptor {
                size_in_pixels: [self.config.width, self.config.height],
                pixels_per_point: output.pixels_per_point,
            };
            let (device, queue) = (&context.device, &context.queue);
            let mut commands = self.renderer.update_buffers(device, queue, &mut encoder, &jobs, &screen);
            let attachment = wgpu::RenderPassColorAttachment {
                view: &view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                    store: wgpu::StoreOp::Store,
                },
            };
            let descriptor = wgpu::RenderPassDescriptor {
                label: Some("window"),
                color_attachments: &[Some(attachment)],
                ..Default::default()
            };
            let mut pass = encoder.begin_render_pass(&descriptor).forget_lifetime();
            self.renderer.render(&mut pass, &jobs, &screen);
            drop(pass);
            commands.push(encoder.finish());
            context.queue.submit(commands);
            self.window.pre_present_notify();
            context.queue.present(frame);
        }
        for id in &output.textures_delta.free {
            self.renderer.free_texture(id);
        }
        output.textures_delta.clear();
    }
}
