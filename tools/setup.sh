# Sourced by tools/demo and tools/test: `setup demo` or `setup test` installs what is missing on Debian and Ubuntu
# and names it elsewhere. When nothing is missing it runs no package manager.
# shellcheck shell=bash

# True when one of the files exists.
any_file() {
  local file
  for file in "$@"; do [[ -e $file ]] && return 0; done
  return 1
}

# Where the Vulkan loader looks for manifests: `vulkan_dirs icd.d`.
vulkan_dirs() {
  printf '%s\n' {/etc,/usr/share,/usr/local/share,/usr/local/etc,/opt/homebrew/share,"${XDG_DATA_HOME:-$HOME/.local/share}"}/vulkan/"$1"
}

has_driver() {
  [[ -n ${VK_DRIVER_FILES:-}${VK_ICD_FILENAMES:-} ]] && return
  local dir
  while read -r dir; do any_file "$dir"/*.json && return; done < <(vulkan_dirs icd.d)
  return 1
}

# The manifest of lavapipe, where it is installed.
lavapipe() {
  local dir file
  while read -r dir; do
    for file in "$dir"/lvp_icd*.json; do [[ ! -e $file ]] || { echo "$file" && return; }; done
  done < <(vulkan_dirs icd.d)
}

has_validation() {
  local dir
  while read -r dir; do
    any_file "$dir/VkLayer_khronos_validation.json" && return
  done < <(vulkan_dirs explicit_layer.d && tr : '\n' <<<"${VK_LAYER_PATH:-}")
  return 1
}

has_library() {
  # not `grep -q`: under pipefail it fails when it closes the pipe early
  PATH=$PATH:/sbin:/usr/sbin ldconfig -p | grep -F "$1 " >/dev/null
}

has_loader() {
  if [[ $OSTYPE == darwin* ]]; then
    any_file {/usr/local,/opt/homebrew}/lib/libvulkan.1.dylib
  else
    has_library libvulkan.so.1
  fi
}

# A compiler without the C library's start files (gcc without libc6-dev) cannot link.
has_linker() {
  command -v cc >/dev/null && { [[ $OSTYPE == darwin* ]] || any_file "$(cc -print-file-name=crt1.o)"; }
}

has_vulkan_headers() {
  cc -E -x c - <<<'#include <vulkan/vulkan.h>' >/dev/null 2>&1
}

has_cpp() { cc -E -x c++ - <<<'#include <cstddef>' >/dev/null 2>&1; }

# Prints the Debian packages that are missing for `demo` or `test`, one a line.
missing() {
  has_linker || printf '%s\n' gcc libc6-dev
  has_loader || echo libvulkan1
  has_driver || echo mesa-vulkan-drivers # lavapipe: Vulkan on the CPU
  if [[ $1 == test ]]; then
    has_validation || echo vulkan-validationlayers
    command -v glslangValidator >/dev/null || echo glslang-tools
    command -v spirv-val >/dev/null || echo spirv-tools
    has_vulkan_headers || echo libvulkan-dev # hosts in C
    has_cpp || echo g++
    # what opens a window, and where: elsewhere than on Linux tools/view_test is skipped
    if [[ $OSTYPE == linux* ]]; then
      [[ -n $(lavapipe)${VK_DRIVER_FILES:-}${VK_ICD_FILENAMES:-} ]] || echo mesa-vulkan-drivers
      command -v Xvfb >/dev/null || echo xvfb
      command -v xdotool >/dev/null || echo xdotool
      has_library libX11.so.6 || echo libx11-6
      has_library libX11-xcb.so.1 || echo libx11-xcb1
      has_library libXcursor.so.1 || echo libxcursor1
      has_library libXi.so.6 || echo libxi6
      has_library libxkbcommon-x11.so.0 || echo libxkbcommon-x11-0
    fi
  fi
}

# What other systems call a Debian package.
elsewhere() {
  local row
  while read -r row; do
    # shellcheck disable=SC2086 # the row is words
    set -- "$1" "$2" $row
    [[ $2 == "$3" ]] && case $1 in dnf) echo "$4" ;; pacman) echo "$5" ;; brew) echo "$6" ;; esac
  done <<'END'
gcc                    gcc                       gcc                       llvm
libc6-dev              glibc-devel               glibc                     llvm
libvulkan1             vulkan-loader             vulkan-icd-loader         vulkan-loader
mesa-vulkan-drivers    mesa-vulkan-drivers       vulkan-swrast             molten-vk
vulkan-validationlayers vulkan-validation-layers vulkan-validation-layers  vulkan-validationlayers
glslang-tools          glslang                   glslang                   glslang
spirv-tools            spirv-tools               spirv-tools               spirv-tools
libvulkan-dev          vulkan-loader-devel       vulkan-headers            vulkan-headers
g++                    gcc-c++                   gcc                       llvm
xvfb                   xorg-x11-server-Xvfb      xorg-server-xvfb          -
xdotool                xdotool                   xdotool                   -
libx11-6               libX11                    libx11                    -
libx11-xcb1            libX11-xcb                libx11                    -
libxcursor1            libXcursor                libxcursor                -
libxi6                 libXi                     libxi                     -
libxkbcommon-x11-0     libxkbcommon-x11          libxkbcommon-x11          -
END
  return 0
}

# apt_install PACKAGE...
apt_install() {
  local packages=$* sudo=() log
  [[ $EUID -eq 0 ]] || sudo=(sudo -n)
  if [[ $EUID -ne 0 ]] && ! sudo -n true 2>/dev/null; then
    echo "missing: $packages; install with: sudo apt-get install $packages" >&2
    return 1
  fi
  echo "installing $packages"
  log=$(mktemp)
  # one broken source makes the update fail; what matters is whether the install succeeds
  if ! { "${sudo[@]}" apt-get update || true
    "${sudo[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends "$@"; } >"$log" 2>&1; then
    cat "$log" >&2
    rm -f "$log"
    echo "could not install $packages" >&2
    return 1
  fi
  rm -f "$log"
}

setup_packages() {
  local packages manager name names
  packages=$(missing "$1")
  [[ -z $packages ]] && return
  packages=${packages//$'\n'/ }

  if command -v apt-get >/dev/null; then
    # shellcheck disable=SC2086 # packages are words
    apt_install $packages
    return
  fi

  for manager in dnf pacman brew; do
    command -v $manager >/dev/null || continue
    names=$(for name in $packages; do elsewhere $manager "$name"; done | sort -u | tr '\n' ' ')
    case $manager in
    dnf) echo "missing; install with: sudo dnf install $names" >&2 ;;
    pacman) echo "missing; install with: sudo pacman -S $names" >&2 ;;
    brew) echo "missing; install with: brew install $names" >&2 ;;
    esac
    return 1
  done
  echo "missing: $packages (Debian's names); install them with this system's package manager" >&2
  return 1
}

# A Chromium, where there is one.
browser() {
  local name
  for name in chromium-headless-shell chromium chromium-browser google-chrome; do command -v $name && return; done
  return 1
}

# What opens tools/report_test's page. Optional, as other systems have no package that runs without a desktop.
setup_browser() {
  browser >/dev/null || { command -v apt-get >/dev/null && apt_install chromium-headless-shell && browser >/dev/null; }
}

setup_rust() {
  local want have root
  root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
  command -v cargo >/dev/null || PATH=$PATH:${CARGO_HOME:-$HOME/.cargo}/bin
  want=$(sed -n 's/^rust-version = "\(.*\)"/\1/p' "$root/Cargo.toml")
  if ! have=$(cargo --version 2>/dev/null | cut -d ' ' -f 2) || [[ -z $have ]]; then
    echo "missing: Rust $want or newer; install it from https://rustup.rs: curl https://sh.rustup.rs -sSf | sh" >&2
    return 1
  fi
  if [[ $(printf '%s\n' "$want" "$have" | sort -V | head -n 1) != "$want" ]]; then
    echo "Rust $have is too old, $want or newer is needed: rustup update (https://rustup.rs)" >&2
    return 1
  fi
  [[ $1 == test ]] || return 0
  cargo fmt --version >/dev/null 2>&1 && cargo clippy --version >/dev/null 2>&1 && return
  if ! command -v rustup >/dev/null || ! rustup component add rustfmt clippy >&2; then
    echo "missing: rustfmt and clippy; install with: rustup component add rustfmt clippy" >&2
    return 1
  fi
}

# setup demo|test
setup() {
  setup_packages "$1" && setup_rust "$1"
}
