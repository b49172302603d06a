/* The functions of OpenGL 4.3 that the back ends call, as a table: nothing here is linked. */
#ifndef BTG_BACKEND_CONTEXT_GL_H
#define BTG_BACKEND_CONTEXT_GL_H

#include <GL/glcorearb.h>

/* X(name, NAME): gl##name of type PFNGL##NAME##PROC. */
#define BTG_GL_STATE(X)                                                                            \
    X(GetError, GETERROR)                                                                          \
    X(GetString, GETSTRING)                                                                        \
    X(GetStringi, GETSTRINGI)                                                                      \
    X(GetIntegerv, GETINTEGERV)                                                                    \
    X(GetIntegeri_v, GETINTEGERI_V)                                                                \
    X(GetInteger64v, GETINTEGER64V)                                                                \
    X(Enable, ENABLE)                                                                              \
    X(Disable, DISABLE)                                                                            \
    X(Finish, FINISH)                                                                              \
    X(Flush, FLUSH)                                                                                \
    X(FenceSync, FENCESYNC)                                                                        \
    X(ClientWaitSync, CLIENTWAITSYNC)                                                              \
    X(DeleteSync, DELETESYNC)                                                                      \
    X(DebugMessageCallback, DEBUGMESSAGECALLBACK)                                                  \
    X(DebugMessageControl, DEBUGMESSAGECONTROL)
#define BTG_GL_BUFFERS(X)                                                                          \
    X(IsBuffer, ISBUFFER)                                                                          \
    X(GenBuffers, GENBUFFERS)                                                                      \
    X(DeleteBuffers, DELETEBUFFERS)                                                                \
    X(BindBuffer, BINDBUFFER)                                                                      \
    X(BindBufferBase, BINDBUFFERBASE)                                                              \
    X(BindBufferRange, BINDBUFFERRANGE)                                                            \
    X(BufferData, BUFFERDATA)                                                                      \
    X(BufferSubData, BUFFERSUBDATA)                                                                \
    X(GetBufferSubData, GETBUFFERSUBDATA)                                                          \
    X(ClearBufferData, CLEARBUFFERDATA)                                                            \
    X(MapBufferRange, MAPBUFFERRANGE)                                                              \
    X(UnmapBuffer, UNMAPBUFFER)                                                                    \
    X(MemoryBarrier, MEMORYBARRIER)
#define BTG_GL_PROGRAMS(X)                                                                         \
    X(CreateShader, CREATESHADER)                                                                  \
    X(DeleteShader, DELETESHADER)                                                                  \
    X(ShaderSource, SHADERSOURCE)                                                                  \
    X(ShaderBinary, SHADERBINARY)                                                                  \
    X(CompileShader, COMPILESHADER)                                                                \
    X(GetShaderiv, GETSHADERIV)                                                                    \
    X(GetShaderInfoLog, GETSHADERINFOLOG)                                                          \
    X(CreateProgram, CREATEPROGRAM)                                                                \
    X(DeleteProgram, DELETEPROGRAM)                                                                \
    X(AttachShader, ATTACHSHADER)                                                                  \
    X(LinkProgram, LINKPROGRAM)                                                                    \
    X(UseProgram, USEPROGRAM)                                                                      \
    X(GetProgramiv, GETPROGRAMIV)                                                                  \
    X(GetProgramInfoLog, GETPROGRAMINFOLOG)                                                        \
    X(GetUniformLocation, GETUNIFORMLOCATION)                                                      \
    X(Uniform1f, UNIFORM1F)                                                                        \
    X(Uniform2f, UNIFORM2F)                                                                        \
    X(Uniform4f, UNIFORM4F)                                                                        \
    X(Uniform1i, UNIFORM1I)                                                                        \
    X(Uniform1ui, UNIFORM1UI)                                                                      \
    X(Uniform4fv, UNIFORM4FV)                                                                      \
    X(UniformMatrix4fv, UNIFORMMATRIX4FV)                                                          \
    X(DispatchCompute, DISPATCHCOMPUTE)
#define BTG_GL_RASTER(X)                                                                           \
    X(GenVertexArrays, GENVERTEXARRAYS)                                                            \
    X(DeleteVertexArrays, DELETEVERTEXARRAYS)                                                      \
    X(BindVertexArray, BINDVERTEXARRAY)                                                            \
    X(EnableVertexAttribArray, ENABLEVERTEXATTRIBARRAY)                                            \
    X(VertexAttribPointer, VERTEXATTRIBPOINTER)                                                    \
    X(VertexAttribIPointer, VERTEXATTRIBIPOINTER)                                                  \
    X(VertexAttribDivisor, VERTEXATTRIBDIVISOR)                                                    \
    X(GenTextures, GENTEXTURES)                                                                    \
    X(DeleteTextures, DELETETEXTURES)                                                              \
    X(ActiveTexture, ACTIVETEXTURE)                                                                \
    X(BindTexture, BINDTEXTURE)                                                                    \
    X(BindImageTexture, BINDIMAGETEXTURE)                                                          \
    X(TexStorage2D, TEXSTORAGE2D)                                                                  \
    X(TexParameteri, TEXPARAMETERI)                                                                \
    X(TexBuffer, TEXBUFFER)                                                                        \
    X(GenFramebuffers, GENFRAMEBUFFERS)                                                            \
    X(DeleteFramebuffers, DELETEFRAMEBUFFERS)                                                      \
    X(BindFramebuffer, BINDFRAMEBUFFER)                                                            \
    X(FramebufferTexture, FRAMEBUFFERTEXTURE)                                                      \
    X(CheckFramebufferStatus, CHECKFRAMEBUFFERSTATUS)                                              \
    X(DrawBuffers, DRAWBUFFERS)                                                                    \
    X(ReadBuffer, READBUFFER)                                                                      \
    X(ReadPixels, READPIXELS)                                                                      \
    X(PixelStorei, PIXELSTOREI)                                                                    \
    X(Viewport, VIEWPORT)                                                                          \
    X(Scissor, SCISSOR)                                                                            \
    X(DepthFunc, DEPTHFUNC)                                                                        \
    X(DepthMask, DEPTHMASK)                                                                        \
    X(DepthRange, DEPTHRANGE)                                                                      \
    X(ClearDepth, CLEARDEPTH)                                                                      \
    X(ClearColor, CLEARCOLOR)                                                                      \
    X(Clear, CLEAR)                                                                                \
    X(ClearBufferfv, CLEARBUFFERFV)                                                                \
    X(ClearBufferuiv, CLEARBUFFERUIV)                                                              \
    X(ColorMask, COLORMASK)                                                                        \
    X(BlendEquation, BLENDEQUATION)                                                                \
    X(BlendFunc, BLENDFUNC)                                                                        \
    X(CullFace, CULLFACE)                                                                          \
    X(DrawArrays, DRAWARRAYS)                                                                      \
    X(DrawArraysInstanced, DRAWARRAYSINSTANCED)                                                    \
    X(DrawElements, DRAWELEMENTS)                                                                  \
    X(DrawElementsInstanced, DRAWELEMENTSINSTANCED)                                                \
    X(MultiDrawArraysIndirect, MULTIDRAWARRAYSINDIRECT)                                            \
    X(MultiDrawElementsIndirect, MULTIDRAWELEMENTSINDIRECT)
/* What the viewer calls besides. */
#define BTG_GL_SCREEN(X)                                                                           \
    X(BindAttribLocation, BINDATTRIBLOCATION)                                                      \
    X(Uniform2i, UNIFORM2I)                                                                        \
    X(Uniform3f, UNIFORM3F)                                                                        \
    X(TexImage2D, TEXIMAGE2D)                                                                      \
    X(PolygonOffset, POLYGONOFFSET)                                                                \
    X(GenRenderbuffers, GENRENDERBUFFERS)                                                          \
    X(DeleteRenderbuffers, DELETERENDERBUFFERS)                                                    \
    X(BindRenderbuffer, BINDRENDERBUFFER)                                                          \
    X(RenderbufferStorageMultisample, RENDERBUFFERSTORAGEMULTISAMPLE)                              \
    X(FramebufferRenderbuffer, FRAMEBUFFERRENDERBUFFER)                                            \
    X(BlitFramebuffer, BLITFRAMEBUFFER)
#define BTG_GL(X)                                                                                  \
    BTG_GL_STATE(X)                                                                                \
    BTG_GL_BUFFERS(X)                                                                              \
    BTG_GL_PROGRAMS(X)                                                                             \
    BTG_GL_RASTER(X)                                                                               \
    BTG_GL_SCREEN(X)

typedef struct btg_gl {
#define BTG_GL_MEMBER(name, NAME) PFNGL##NAME##PROC name;
    BTG_GL(BTG_GL_MEMBER)
#undef BTG_GL_MEMBER
    /* OpenGL 4.5 or GL_ARB_robustness; elsewhere one that knows of no reset. */
    PFNGLGETGRAPHICSRESETSTATUSARBPROC GetGraphicsResetStatus;
    /* OpenGL 4.6 or GL_ARB_gl_spirv: a stub elsewhere; ask btg_context_spirv. */
    PFNGLSPECIALIZESHADERARBPROC SpecializeShaderARB;
} btg_gl;

#endif
