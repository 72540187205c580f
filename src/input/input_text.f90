!> Files that a user names: how they begin, text that is read whole, and what readers share.
!>
!> A byte order mark is skipped, UTF-16 and files of other programs are named, and a carriage return
!> alone ends a line, whatever is read.
module asperity_input_text
  use asperity_byte_reader, only: byte_reader
  use asperity_problems, only: not_enough_memory, problem_list
  implicit none
  private

  public :: blanks, read_text, check_text, line_end, lower_case, in_quotes, replaced_text, &
            without_blanks
  public :: begin_file, first_control, plain_text, skip_mark

  !> Characters that only separate.
  character(len=*), parameter :: blanks = ' ' // achar(9) // achar(10) // achar(13)

  ! A longer piece of the file is not repeated in a message.
  integer, parameter :: most_repeated = 40

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

  !> Reads a whole file; a file that cannot be read is a problem at its first byte.
  recursive subroutine read_text(path, expected_kind, text, problems, opened)
    character(len=*), intent(in) :: path                !! the file; `-` is standard input
    character(len=*), intent(in) :: expected_kind       !! what it should be, for the message
    character(len=:), allocatable, intent(out) :: text  !! its lines, as `plain_text` has them
    type(problem_list), intent(inout) :: problems       !! names this file from now on
    class(byte_reader), intent(inout), optional :: opened  !! the file, at its first byte
    type(byte_reader) :: file
    integer :: before

    if (.not. present(opened)) then
      call file%open(path)
      call read_text(path, expected_kind, text, problems, file)
      call file%close()
      return
    end if
    call problems%start(path)
    before = problems%count()
    call begin_file(opened, expected_kind, problems)
    text = ''
    if (.not. allocated(opened%failure)) call opened%take_whole(text)
    if (.not. allocated(opened%failure)) then
      text = plain_text(text)
      return
    end if
    problems%lacks_memory = index(opened%failure, not_enough_memory) > 0
    if (problems%count() == before) &
      call problems%add_at(1, 1, opened%failure // ', expected ' // expected_kind)
    text = ''
  end subroutine read_text

  !> Reports the first byte that is no text.
  pure subroutine check_text(text, expected_kind, problems)
    character(len=*), intent(in) :: text           !! the whole file
    character(len=*), intent(in) :: expected_kind  !! what it should be, for the message
    type(problem_list), intent(inout) :: problems  !! gets a problem when there is such a byte
    integer :: place

    place = first_control(text)
    if (place > 0) call problems%add_at_byte(text, place, 'not a text file: found a control ' // &
                                             'character, expected ' // expected_kind)
  end subroutine check_text

  !> Last character of the line, its line feed left out; `at - 1` when nothing is there.
  pure integer function line_end(text, at)
    character(len=*), intent(in) :: text  !! the whole file
    integer, intent(in) :: at             !! place in the line, at most one behind the text

    line_end = index(text(at:), achar(10)) + at - 2
    if (line_end < at - 1) line_end = len(text)
  end function line_end

  !> The text with its ASCII capitals made small.
  pure function lower_case(text) result(small)
    character(len=*), intent(in) :: text  !! text of any bytes
    character(len=len(text)) :: small     !! the same in small letters
    integer :: i, code

    do i = 1, len(text)
      code = iachar(text(i:i))
      if (code >= iachar('A') .and. code <= iachar('Z')) code = code + 32
      small(i:i) = achar(code)
    end do
  end function lower_case

  !> Text without blanks and tabulators around it.
  pure function without_blanks(text) result(inner)
    character(len=*), intent(in) :: text    !! text with or without them
    character(len=:), allocatable :: inner  !! the same, or empty
    integer :: first

    first = verify(text, blanks)
    inner = ''
    if (first > 0) inner = text(first:verify(text, blanks, back=.true.))
  end function without_blanks

  !> A text with other letters in the place of each of one kind.
  pure function replaced_text(text, letter, by) result(other)
    character(len=*), intent(in) :: text     !! text of any bytes
    character(len=1), intent(in) :: letter   !! letter that is replaced
    character(len=*), intent(in) :: by       !! letters in its place
    character(len=:), allocatable :: other   !! the other text
    integer :: i, used

    used = 0
    do i = 1, len(text)
      used = used + merge(len(by), 1, text(i:i) == letter)
    end do
    allocate (character(len=used) :: other)
    used = 0
    do i = 1, len(text)
      if (text(i:i) == letter) then
        other(used + 1:used + len(by)) = by
        used = used + len(by)
      else
        used = used + 1
        other(used:used) = text(i:i)
      end if
    end do
  end function replaced_text

  !> A piece of the file for a message: between quotes, cut when long.
  pure function in_quotes(piece) result(text)
    character(len=*), intent(in) :: piece  !! the piece as it was found
    character(len=:), allocatable :: text  !! for instance `'1.2.3'`

    if (len(piece) <= most_repeated) then
      text = '''' // piece // ''''
    else
      text = '''' // piece(:most_repeated) // '...'''
    end if
  end function in_quotes

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
      first = other_formats(i)%offset + 1
      if (head(first:min(len(head), first + len_trim(other_formats(i)%signature) - 1)) /= &
          other_formats(i)%signature) cycle
      found = trim(other_formats(i)%name) // ', not a format of this program'
      if (other_formats(i)%is_surface) &
        remedy = '; asperity.read_map in Python reads such surfaces'
    end do
    if (found /= '') &
      call problems%add_at(1, 1, 'found ' // found // ', expected ' // expected // remedy)
  end subroutine begin_file

  !> Steps over a mark of byte order before UTF-8 at the first byte of a file.
  subroutine skip_mark(file)
    class(byte_reader), intent(inout) :: file  !! open, at its first byte

    if (file%at > file%used .and. .not. allocated(file%failure)) call file%more()
    if (file%block(file%at:min(file%used, file%at + 2)) == utf_8_mark) &
      file%at = file%at + len(utf_8_mark)
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
    if (bytes(:min(len(bytes), len(utf_8_mark))) == utf_8_mark) text = bytes(len(utf_8_mark) + 1:)
    if (index(text, return_sign) == 0) return
    do i = 1, len(text)
      if (text(i:i) /= return_sign) cycle
      if (text(min(i + 1, len(text)):min(i + 1, len(text))) /= feed) text(i:i) = feed
    end do
  end function plain_text

end module asperity_input_text
