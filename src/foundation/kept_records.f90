!> Work in pieces (positions, surfaces) whose results are kept in a file, from which a rerun
!> continues, and by which the images of a run share the work; or the files of several parts of it.
!>
!> The first line identifies the work by a checksum of all its input. Each piece that is done is
!> appended, in any order: a line with its number, its number of words of 64 bits and their
!> checksum, and a line with the words, 16 hexadecimal digits each. A record is one write. One that
!> was interrupted or damaged is left out by its checksum, and its piece is done again.
module asperity_kept_records
  use, intrinsic :: iso_c_binding, only: c_int, c_long, c_null_char
  use asperity_byte_reader, only: byte_reader
  use asperity_files, only: write_bytes
  use asperity_images, only: image_count, image_number, mark_of_failure, mark_of_run, read_mark, &
                             set_mark, wait_for_images
  use asperity_kinds, only: int64
  use asperity_output_files, only: commit_files, stage_file
  use asperity_problems, only: decimal_text
  use asperity_system_calls, only: posix_close, posix_getpid, posix_lseek, posix_open, &
                                   posix_unlink, system_error, system_reason
  implicit none
  private

  public :: kept_file, kept_work, pieces_of_part, whole_number
  public :: begin_work, close_work, is_due, keep_record, next_record, share_work
  public :: checksum

  !> A file of kept work.
  type :: kept_file
    character(len=:), allocatable :: path      !! path as the user gave it
  end type kept_file

  !> Work and its file. Part I of N of the work consists of its pieces I, I + N, I + 2 N and so on;
  !> in its file they are numbered from 1.
  type :: kept_work
    character(len=:), allocatable :: path      !! path of the file; empty: none
    integer :: part = 1                        !! number of the part that is done, from 1
    integer :: parts = 1                       !! number of parts
    type(kept_file), allocatable :: more(:)    !! files of further parts, to be combined
    character(len=:), allocatable :: heading   !! first line, which identifies the work
    character(len=:), allocatable :: piece     !! name of a piece, for instance `surface`
    character(len=:), allocatable :: of_what   !! name of the input: `this specification`
    logical, allocatable :: is_done(:)         !! pieces whose results this image has
    integer :: done = 0                        !! number of these pieces
    logical :: is_packed = .false.             !! results are written as records
    logical :: is_shared = .false.             !! other images do pieces, too
    logical, private :: is_own_file = .false.  ! the file is removed at the end
    integer(c_int), private :: descriptor = -1_c_int  ! of the file, for appending
    integer, private :: file = 0, from = 0     ! number of the file that is read, part in it
    logical, allocatable, private :: is_there(:)  ! parts whose files were read
    type(byte_reader), private :: reader
  end type kept_work

  ! O_RDONLY with O_NONBLOCK, and O_WRONLY with O_APPEND and O_NONBLOCK, of Linux: without
  ! O_NONBLOCK the open of a pipe blocks until its other end is open.
  integer(c_int), parameter :: read_only = 2048_c_int, append = 3073_c_int, no_such_file = 2_c_int
  integer(c_int), parameter :: from_start = 0_c_int
  integer, parameter :: word_digits = 16

contains

  !> Starts work: opens its file. The records of an earlier run follow by `next_record`. To be
  !> called by all images of shared work. `failure` is allocated when the file belongs to other work
  !> or cannot be used.
  subroutine begin_work(work, total, shared, failure)
    type(kept_work), intent(inout) :: work                 !! work with its names
    integer, intent(in) :: total                           !! number of pieces
    logical, intent(in) :: shared                          !! all images share the work
    character(len=:), allocatable, intent(out) :: failure  !! reason, when the file cannot be used

    allocate (work%is_done(total), source=.false.)
    if (.not. allocated(work%more)) allocate (work%more(0))
    work%is_shared = shared .and. image_count() > 1
    work%is_own_file = work%is_shared .and. work%path == ''
    work%is_packed = work%is_shared .or. work%path /= ''
    if (.not. work%is_packed) return
    if (work%is_shared .and. image_number() == 1) then
      call set_mark(mark_of_failure, huge(1))
      call set_mark(mark_of_run, int(posix_getpid()))
    end if
    if (work%is_shared) call wait_for_images()
    if (work%is_own_file) &
      work%path = '.asperity.' // decimal_text(read_mark(mark_of_run)) // '.images'
    if (image_number() == 1 .and. size(work%more) == 0) then
      call prepare_file(work, failure)
      if (work%is_shared .and. allocated(failure)) call set_mark(mark_of_failure, 0)
    end if
    if (work%is_shared) call wait_for_images()
    if (allocated(failure)) return
    if (work%is_shared .and. read_mark(mark_of_failure) == 0) then
      failure = work%path // ': cannot be used by image 1'
      return
    end if
    allocate (work%is_there(1 + size(work%more)), source=.false.)
    call open_file(work, 1, failure)
    if (allocated(failure) .or. size(work%more) > 0) return
    work%descriptor = posix_open(work%path // c_null_char, append)
    if (work%descriptor < 0) failure = work%path // ': cannot be written: ' // system_reason()
  end subroutine begin_work

  ! Checks the file of an earlier run, or begins a new one.
  subroutine prepare_file(work, failure)
    type(kept_work), intent(in) :: work
    character(len=:), allocatable, intent(out) :: failure
    character(len=:), allocatable :: found, heading
    type(byte_reader) :: reader
    integer(c_int) :: descriptor, status

    heading = first_line(work, work%part, work%parts)
    found = ''
    descriptor = posix_open(work%path // c_null_char, read_only)
    if (descriptor >= 0) then
      if (posix_lseek(descriptor, 0_c_long, from_start) < 0_c_long) then
        failure = work%path // ': is a pipe or a terminal, expected a file for what is kept'
      end if
      status = posix_close(descriptor)
      if (allocated(failure)) return
      call reader%open(work%path)
      if (.not. allocated(reader%failure)) call reader%take(len(heading), found)
      if (allocated(reader%failure)) failure = work%path // ': ' // reader%failure
      call reader%close()
    else if (system_error() /= no_such_file) then
      failure = work%path // ': cannot be opened: ' // system_reason()
    end if
    if (allocated(failure)) return
    if (found /= heading(:len(found))) then
      failure = work%path // ': holds no ' // work%piece // 's of ' // work%of_what // &
                ', expected a file that a run with the same text kept, or none'
    else if (len(found) < len(heading)) then
      call stage_file(work%path, heading, failure)
      if (.not. allocated(failure)) call commit_files(failure)
    end if
  end subroutine prepare_file

  ! Opens one of the files for reading, behind its first line.
  subroutine open_file(work, file, failure)
    type(kept_work), intent(inout) :: work
    integer, intent(in) :: file
    character(len=:), allocatable, intent(out) :: failure
    character(len=:), allocatable :: heading
    integer :: part, parts
    logical :: found

    work%file = file
    call work%reader%open(path_of(work))
    if (.not. allocated(work%reader%failure)) call work%reader%take_line(heading, found)
    if (allocated(work%reader%failure)) then
      failure = path_of(work) // ': ' // work%reader%failure
      return
    end if
    work%from = 1
    parts = size(work%is_there)
    if (parts == 1) return
    do part = 1, parts
      if (heading // new_line('a') == first_line(work, part, parts)) exit
    end do
    work%from = part
    if (part > parts) then
      failure = path_of(work) // ': holds no part of ' // decimal_text(parts) // ' of the ' // &
                work%piece // 's of ' // work%of_what // ', expected the files of all ' // &
                decimal_text(parts) // ' parts that --share kept, each with one --keep'
    else if (work%is_there(part)) then
      failure = path_of(work) // ': holds part ' // decimal_text(part) // ' of ' // &
                decimal_text(parts) // ' once more, expected each part once'
    else
      work%is_there(part) = .true.
    end if
  end subroutine open_file

  ! Path of the file that is read.
  pure function path_of(work) result(path)
    type(kept_work), intent(in) :: work
    character(len=:), allocatable :: path

    path = work%path
    if (work%file > 1) path = work%more(work%file - 1)%path
  end function path_of

  ! The first line of a file, with its end.
  pure function first_line(work, part, parts) result(line)
    type(kept_work), intent(in) :: work
    integer, intent(in) :: part, parts
    character(len=:), allocatable :: line

    line = work%heading
    if (parts > 1) line = line // ', part ' // decimal_text(part) // ' of ' // decimal_text(parts)
    line = line // new_line('a')
  end function first_line

  !> Number of pieces of a part of the work.
  elemental integer function pieces_of_part(pieces, part, parts) result(number)
    integer, intent(in) :: pieces  !! number of all pieces
    integer, intent(in) :: part, parts  !! number of the part, from 1, and of all parts

    number = (pieces - part + parts) / parts
  end function pieces_of_part

  !> Number in the whole work of a piece of a part.
  elemental integer function whole_number(piece, part, parts) result(number)
    integer, intent(in) :: piece   !! number in the part
    integer, intent(in) :: part, parts  !! number of the part, from 1, and of all parts

    number = part + (piece - 1) * parts
  end function whole_number

  !> Reads the next record of a piece that is not done, which is done then; 0 behind the last one.
  !> `failure` is allocated when a file cannot be read, or a part is missing or incomplete.
  subroutine next_record(work, piece, words, failure)
    type(kept_work), intent(inout) :: work                   !! work of begin_work
    integer, intent(out) :: piece                            !! number of the piece; 0: none
    integer(int64), allocatable, intent(out) :: words(:)     !! result of the piece
    character(len=:), allocatable, intent(out) :: failure    !! reason, when they are incomplete
    character(len=:), allocatable :: body, line
    integer :: done, pieces
    logical :: found

    piece = 0
    if (work%file == 0) return
    files: do
      pieces = pieces_of_part(size(work%is_done), work%from, size(work%is_there))
      call work%reader%take_line(line, found)
      do while (found)
        call work%reader%take_line(body, found)
        if (.not. found) exit
        ! An interrupted record has no end of a line.
        line = line(max(1, index(line, work%piece // ' ', back=.true.)):)
        piece = piece_in_heading(work%piece, line)
        if (piece >= 1 .and. piece <= pieces) then
          if (line == heading_of(work%piece, piece, body)) then
            piece = whole_number(piece, work%from, size(work%is_there))
            if (.not. work%is_done(piece)) exit files
            call work%reader%take_line(body, found)
          end if
        end if
        call move_alloc(body, line)
      end do
      piece = 0
      if (allocated(work%reader%failure)) failure = path_of(work) // ': ' // work%reader%failure
      call work%reader%close()
      if (size(work%more) > 0 .and. .not. allocated(failure)) then
        done = count(work%is_done(work%from::size(work%is_there)))
        if (done < pieces) failure = path_of(work) // ': holds ' // decimal_text(done) // &
          ' of ' // decimal_text(pieces) // ' ' // work%piece // 's, expected all: run it ' // &
          'with --share ' // decimal_text(work%from) // '/' // &
          decimal_text(size(work%is_there)) // ' to its end'
      end if
      if (allocated(failure) .or. work%file > size(work%more)) then
        work%file = 0
        return
      end if
      call open_file(work, work%file + 1, failure)
      if (allocated(failure)) return
    end do files
    work%is_done(piece) = .true.
    work%done = work%done + 1
    allocate (words(len(body, int64) / word_digits))
    read (body, '(*(z16))') words
  end subroutine next_record

  !> Whether this image is to do a piece. Pieces are distributed in turn.
  elemental logical function is_due(work, piece)
    type(kept_work), intent(in) :: work  !! work whose records are read
    integer, intent(in) :: piece         !! number of the piece

    is_due = .not. work%is_done(piece)
    if (work%is_shared) &
      is_due = is_due .and. modulo(piece - 1, image_count()) == image_number() - 1
  end function is_due

  !> Appends the record of a piece, which is done then; one thread calls it at a time. `failure` is
  !> allocated when it cannot be written.
  subroutine keep_record(work, piece, words, failure)
    type(kept_work), intent(inout) :: work                 !! work whose records are read
    integer, intent(in) :: piece                           !! number of the piece
    integer(int64), intent(in) :: words(:)                 !! result of the piece
    character(len=:), allocatable, intent(out) :: failure  !! reason, when it cannot be written
    character(len=:), allocatable :: body  ! may be larger than a stack

    allocate (character(len=word_digits * size(words, kind=int64)) :: body)
    write (body, '(*(z16.16))') words
    call write_bytes(work%descriptor, heading_of(work%piece, piece, body) // new_line('a') // &
                     body // new_line('a'), failure)
    if (allocated(failure)) then
      failure = work%path // ': cannot be written: ' // failure
    else
      work%is_done(piece) = .true.
      work%done = work%done + 1
    end if
  end subroutine keep_record

  !> Waits for all images of shared work; image 1 then reads their records by `next_record` and does
  !> what is missing.
  subroutine share_work(work, failure)
    type(kept_work), intent(inout) :: work                 !! work whose pieces are done
    character(len=:), allocatable, intent(out) :: failure  !! reason: an image is lost
    logical :: is_lost

    if (.not. work%is_shared) return
    call wait_for_images(is_lost)
    work%is_shared = .false.
    if (is_lost) failure = 'an image of the run is lost'
    if (.not. is_lost .and. image_number() == 1) call open_file(work, 1, failure)
  end subroutine share_work

  !> Closes the file, and removes it where it has served the images only.
  subroutine close_work(work)
    type(kept_work), intent(inout) :: work  !! work that ends
    integer(c_int) :: status

    call work%reader%close()
    if (work%descriptor >= 0) status = posix_close(work%descriptor)
    work%descriptor = -1_c_int
    if (work%is_own_file .and. image_number() == 1) status = posix_unlink(work%path // c_null_char)
  end subroutine close_work

  ! Number of the piece in the line before a record; 0 for another line.
  pure integer function piece_in_heading(name, line) result(piece)
    character(len=*), intent(in) :: name, line
    integer :: status

    status = 1
    if (index(line, name // ' ') == 1) &
      read (line(len(name) + 2:index(line, ',') - 1), '(i10)', iostat=status) piece
    if (status /= 0) piece = 0
  end function piece_in_heading

  ! The line before the words of a record.
  pure function heading_of(name, piece, body) result(line)
    character(len=*), intent(in) :: name, body
    integer, intent(in) :: piece
    character(len=:), allocatable :: line

    line = name // ' ' // decimal_text(piece) // ', words ' // &
           decimal_text(len(body, int64) / word_digits) // ', checksum ' // checksum(body)
  end function heading_of

  !> FNV-1a of 32 bits (Fowler, Noll, Vo), as 8 hexadecimal digits.
  pure function checksum(text) result(word)
    character(len=*), intent(in) :: text  !! text of any bytes
    character(len=8) :: word
    integer(int64), parameter :: prime = 16777619_int64, low_32 = int(z'FFFFFFFF', int64)
    integer(int64) :: i, state

    state = 2166136261_int64
    do i = 1_int64, len(text, int64)
      state = iand(ieor(state, int(iachar(text(i:i)), int64)) * prime, low_32)
    end do
    write (word, '(z8.8)') state
  end function checksum

end module asperity_kept_records
