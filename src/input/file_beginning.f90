!> The beginning of a file, the same for all readers: a byte order mark is skipped, UTF-16 and files
!> of other programs are named, and a carriage return alone ends a line.
module asperity_file_beginning
  use asperity_byte_reader, only: byte_reader
  use asperity_problems, only: problem_list
  implicit none
  private

  public :: begin_file, first_control, skip_mark, plain_text

  character(len=1), parameter :: feed = achar(10), return_sign = achar(13), nul = achar(0)
  character(len=*), parameter :: utf_8_mark = char(239) // char(187) // char(191)

  integer, parameter :: head_length = 32  ! bytes that tell a format

  !> A format of other programs.
  type :: other_format
    integer :: offset = 0           ! bytes before its signature
    character(len=12) :: signature  ! bytes, blanks at the end left out
    character(len=48) :: name
    logical :: is_surface = .true.  ! SurfaceTopography reads it
  end type other_format

  ! Signatures after the documents of the formats, and SurfaceTopography 1.27.
  type(other_format), parameter :: other_formats(48) = [ &
    other_format(0, 'PK' // achar(3) // achar(4), 'a zip archive (.x3p, .plux, .nms, .npz)'), &
    other_format(0, 'GWYP', 'a Gwyddion file (.gwy)'), &
    other_format(0, 'DIGITAL SURF', 'a file of Digital Surf (.sur)'), &
    other_format(0, 'DSCOMPRESSED', 'a file of Digital Surf (.sur)'), &
    other_format(0, char(137) // 'HDF', 'an HDF5 file (.h5, .nc, .datx, .mat)'), &
    other_format(0, 'CDF' // achar(1), 'a NetCDF file (.nc)'), &
    other_format(0, 'CDF' // achar(2), 'a NetCDF file (.nc)'), &
    other_format(0, 'CDF' // achar(5), 'a NetCDF file (.nc)'), &
    other_format(0, 'MATLAB 5.0', 'a MATLAB file (.mat)'), &
    other_format(2, 'Directory', 'a file of Wyko (.opd)'), &
    other_format(0, 'VCA DATA', 'a file of Dektak (.opdx)'), &
    other_format(0, '\*File list', 'a file of Nanoscope (.di, .spm)'), &
    other_format(0, '\*EC File', 'a file of Nanoscope (.di, .spm)'), &
    other_format(0, char(136) // achar(27) // achar(3), 'a file of Zygo MetroPro (.dat)'), &
    other_format(0, 'FRTM_GLIDERV', 'a file of FRT MicroProf (.frt)'), &
    other_format(0, 'AliconaImagi', 'a file of Alicona (.al3d)'), &
    other_format(0, 'OmniSurf3D', 'a file of OmniSurf3D (.os3d)'), &
    other_format(0, 'VK3_', 'a file of Keyence (.vk3)'), &
    other_format(0, 'VK4_', 'a file of Keyence (.vk4)'), &
    other_format(0, 'VK6', 'a file of Keyence (.vk6)'), &
    other_format(0, 'VK7', 'a file of Keyence (.vk7)'), &
    other_format(0, 'KPK', 'a file of Keyence (.zon)'), &
    other_format(0, 'Binary TrueM', 'a file of TrueMap (.tmd)'), &
    other_format(0, 'Zeta-Instrum', 'a file of KLA Zeta (.zmg)'), &
    other_format(0, achar(1) // char(176) // char(147) // char(255), 'a file of NT-MDT (.mdt)'), &
    other_format(0, 'fileType', 'a file of Molecular Imaging (.mi)'), &
    other_format(0, 'fileformat =', 'a file of BCR-STM (.bcr)'), &
    other_format(0, 'WSxM file', 'a file of WSxM (.stp, .top)'), &
    other_format(0, 'II*' // nul, 'a TIFF image (.tiff, .jpk, .lext)'), &
    other_format(0, 'MM' // nul // '*', 'a TIFF image (.tiff, .jpk, .lext)'), &
    other_format(0, char(208) // char(207) // achar(17) // char(224), 'an OLE file (.mnt, .oir, ' &
                 // '.qep, .xls)'), &
    other_format(0, '[DataSet]', 'a file of Nanosurf (.ezd)'), &
    other_format(0, ':NANONIS', 'a file of Nanonis (.sxm)', .false.), &
    other_format(0, 'Wyko ASCII', 'a text of Wyko (.asc)', .false.), &
    other_format(0, 'Zygo', 'a text of Zygo (.asc, .xyz)', .false.), &
    other_format(0, 'DSBB', 'a binary grid of Surfer (.grd)', .false.), &
    other_format(0, 'DSRB', 'a binary grid of Surfer (.grd)', .false.), &
    other_format(0, achar(31) // char(139), 'a file that gzip packed (.gz)', .false.), &
    other_format(0, 'BZh', 'a file that bzip2 packed (.bz2)', .false.), &
    other_format(0, char(253) // '7zXZ', 'a file that xz packed (.xz)', .false.), &
    other_format(0, char(137) // 'PNG', 'a PNG image', .false.), &
    other_format(0, char(255) // char(216) // char(255), 'a JPEG image', .false.), &
    other_format(0, 'GIF8', 'a GIF image', .false.), &
    other_format(0, '%PDF', 'a PDF document', .false.), &
    other_format(0, '{\rtf', 'an RTF document', .false.), &
    other_format(0, '<?xml', 'an XML document', .false.), &
    other_format(0, '<!DOCTYPE', 'an HTML document', .false.), &
    other_format(0, '<html', 'an HTML document', .false.)]

contains

  !> Begins to read a file at its first byte behind a mark of byte order. A file that cannot be
  !> read, in UTF-16, or in a format of another program is a problem.
  subroutine begin_file(file, expected, problems)
    class(byte_reader), intent(inout) :: file      !! open, at its first byte
    character(len=*), intent(in) :: expected       !! what the file should be, for the message
    type(problem_list), intent(inout) :: problems  !! names the file
    character(len=:), allocatable :: found, head, remedy
    integer :: i, first

    call skip_mark(file)
    if (allocated(file%failure)) then
      call problems%add_at(1, 1, file%failure // ', expected ' // expected)
      return
    end if
    found = ''
    remedy = ''
    head = file%block(file%at:min(file%used, file%at + head_length - 1))
    if (is_utf_16(head)) then
      found = 'text in UTF-16'
      remedy = ', saved as UTF-8 or ASCII'
    end if
    do i = 1, size(other_formats)
      first = min(other_formats(i)%offset, len(head)) + 1
      if (index(head(first:), trim(other_formats(i)%signature)) /= 1) cycle
      found = trim(other_formats(i)%name) // ', not a format of this program'
      if (other_formats(i)%is_surface) &
        remedy = '; the Python package reads such surfaces with SurfaceTopography'
    end do
    if (found /= '') &
      call problems%add_at(1, 1, 'found ' // found // ', expected ' // expected // remedy)
  end subroutine begin_file

  !> Steps over a mark of byte order before UTF-8 at the first byte of a file.
  subroutine skip_mark(file)
    class(byte_reader), intent(inout) :: file  !! open, at its first byte

    if (file%at > file%used .and. .not. allocated(file%failure)) call file%more()
    if (index(file%block(file%at:file%used), utf_8_mark) == 1) file%at = file%at + len(utf_8_mark)
  end subroutine skip_mark

  ! Whether a file begins like text in UTF-16: with its mark, or with three ASCII characters.
  pure logical function is_utf_16(head)
    character(len=*), intent(in) :: head
    integer :: i

    is_utf_16 = .false.
    if (len(head) < 2) return
    is_utf_16 = any(head(:2) == [char(255) // char(254), char(254) // char(255)])
    do i = 0, 1
      if (len(head) < 6 .or. is_utf_16) return
      is_utf_16 = all([head(1 + i:1 + i), head(3 + i:3 + i), head(5 + i:5 + i)] == nul) .and. &
                  .not. any([is_control(head(2 - i:2 - i)), is_control(head(4 - i:4 - i)), &
                             is_control(head(6 - i:6 - i))])
    end do
  end function is_utf_16

  !> Place of the first byte that is none of a text; 0: there is none.
  pure integer function first_control(bytes)
    character(len=*), intent(in) :: bytes  !! beginning of a file

    do first_control = 1, len(bytes)
      if (is_control(bytes(first_control:first_control))) return
    end do
    first_control = 0
  end function first_control

  ! Whether a byte is none of a text.
  elemental logical function is_control(byte)
    character(len=1), intent(in) :: byte

    is_control = iachar(byte) == 127 .or. &
      (iachar(byte) < 32 .and. index(achar(9) // feed // return_sign, byte) == 0)
  end function is_control

  !> The text of a whole file without a mark of byte order, each line ended by a line feed.
  pure function plain_text(bytes) result(text)
    character(len=*), intent(in) :: bytes   !! all bytes of the file
    character(len=:), allocatable :: text   !! a carriage return alone is a line feed
    integer :: i

    text = bytes
    if (index(text, utf_8_mark) == 1) text = bytes(len(utf_8_mark) + 1:)
    if (index(text, return_sign) == 0) return
    do i = 1, len(text)
      if (text(i:i) /= return_sign) cycle
      if (text(min(i + 1, len(text)):min(i + 1, len(text))) /= feed) text(i:i) = feed
    end do
  end function plain_text

end module asperity_file_beginning
