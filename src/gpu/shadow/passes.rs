//! Formats from the descriptors of passes, and passes that fit a format.

use super::errors::ShadowError;
use super::format::ShadowFormat;
use crate::shadow::ShadowCamera;

impl ShadowFormat {
    /// The format for passes like this one, and cameras like this one: the formats and samples of its attachments, and what
    /// [`Self::of_camera`] gives.
    ///
    /// Formats are those of the textures. For a view that was made with another format, as an sRGB view of a linear
    /// texture is, set [`Self::colors`].
    ///
    /// # Errors
    /// [`ShadowError::NoDepthStencil`] if the pass has no depth-stencil attachment, [`ShadowError::Camera`] if no
    /// shadow volumes can be drawn for the camera.
    pub fn of_pass(pass: &wgpu::RenderPassDescriptor<'_>, camera: &ShadowCamera) -> Result<Self, ShadowError> {
        Self::of_camera(camera)?.with_attachments(pass)
    }

    /// The same with the attachments of a pass.
    fn with_attachments(self, pass: &wgpu::RenderPassDescriptor<'_>) -> Result<Self, ShadowError> {
        let depth_stencil = pass.depth_stencil_attachment.as_ref().ok_or(ShadowError::NoDepthStencil)?.view.texture();
        let colors = pass.color_attachments.iter().map(|color| Some(color.as_ref()?.view.texture().format())).collect();
        Ok(Self { depth_stencil: depth_stencil.format(), samples: depth_stencil.sample_count(), colors, ..self })
    }

    /// Begins a pass for the volumes of one light, into which pipelines of this format draw. The pass clears its
    /// stencil to 0, as [`Self::attachment`] does. Begin a pass that counts on from an earlier one by the encoder.
    ///
    /// Colour formats that differ only in sRGB are taken, because a view does not tell its own format. wgpu reports them.
    ///
    /// # Errors
    /// [`ShadowError::NoDepthStencil`] if the pass has no depth-stencil attachment.
    /// [`ShadowError::OtherAttachments`] if the formats or samples of the attachments differ from those of this format.
    /// [`ShadowError::StencilNotCleared`] if the pass does not clear the stencil to 0.
    /// [`ShadowError::DepthCleared`] if it clears the depth, which volumes are compared with. Nothing is begun then.
    pub fn begin_pass<'encoder>(
        &self,
        encoder: &'encoder mut wgpu::CommandEncoder,
        pass: &wgpu::RenderPassDescriptor<'_>,
    ) -> Result<wgpu::RenderPass<'encoder>, ShadowError> {
        let given = self.clone().with_attachments(pass)?;
        if given.without_srgb() != self.without_srgb() {
            return Err(ShadowError::OtherAttachments { pass: Box::new(given), format: Box::new(self.clone()) });
        }
        let attachment = pass.depth_stencil_attachment.as_ref();
        let loads =
            attachment.map(|of| (of.depth_ops.map(|depth| depth.load), of.stencil_ops.map(|stencil| stencil.load)));
        match loads {
            Some((Some(wgpu::LoadOp::Clear(_)), _)) => Err(ShadowError::DepthCleared),
            Some((_, Some(wgpu::LoadOp::Clear(0)))) => Ok(encoder.begin_render_pass(pass)),
            _ => Err(ShadowError::StencilNotCleared),
        }
    }
}
