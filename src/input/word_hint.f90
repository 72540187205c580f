!> Words that are known, for messages, and the one that was probably meant.
module asperity_word_hint
  implicit none
  private

  public :: nearest_word, did_you_mean, any_of, one_of

contains

  !> Number of the word nearest to one that was found; 0 when none is near or two are.
  !>
  !> Near is one slip of the keyboard, or one in every three letters of a longer word: a letter
  !> wrong, missing, too many, or two that changed places.
  pure integer function nearest_word(found, words) result(nearest)
    character(len=*), intent(in) :: found     !! in small letters
    character(len=*), intent(in) :: words(:)  !! those that are known
    integer :: i, slips(size(words)), allowed

    allowed = min(max(1, len_trim(found) / 3), len_trim(found) - 1)
    slips = [(slips_between(trim(found), trim(words(i))), i=1, size(words))]
    nearest = minloc(slips, 1)
    if (nearest == 0) return
    if (slips(nearest) > allowed) nearest = 0
    if (nearest == 0) return
    if (any(slips == slips(nearest) .and. words /= words(nearest))) nearest = 0
  end function nearest_word

  !> `; did you mean 'x_first'?`, or nothing.
  pure function did_you_mean(found, words) result(text)
    character(len=*), intent(in) :: found     !! in small letters
    character(len=*), intent(in) :: words(:)  !! those that are known
    character(len=:), allocatable :: text     !! for the end of a message
    integer :: i

    text = ''
    i = nearest_word(found, words)
    if (i > 0) text = '; did you mean ''' // trim(words(i)) // '''?'
  end function did_you_mean

  ! Least number of slips that make one word of another (restricted Damerau-Levenshtein distance).
  pure integer function slips_between(a, b)
    character(len=*), intent(in) :: a, b
    integer :: slips(-1:len(a), -1:len(b)), i, j

    ! Slips between the first i and j letters.
    slips(0:, 0) = [(i, i=0, len(a))]
    slips(0, 0:) = [(j, j=0, len(b))]
    do j = 1, len(b)
      do i = 1, len(a)
        slips(i, j) = min(slips(i - 1, j) + 1, slips(i, j - 1) + 1, &
                          slips(i - 1, j - 1) + merge(0, 1, a(i:i) == b(j:j)))
        if (i == 1 .or. j == 1) cycle
        if (a(i - 1:i) == b(j:j) // b(j - 1:j - 1)) &
          slips(i, j) = min(slips(i, j), slips(i - 2, j - 2) + 1)
      end do
    end do
    slips_between = slips(len(a), len(b))
  end function slips_between

  !> `x_first, x_step or positions`, each between two marks when these are given.
  pure function any_of(words, before, behind) result(text)
    character(len=*), intent(in) :: words(:)         !! at least one
    character(len=*), intent(in), optional :: before !! stands before each word
    character(len=*), intent(in), optional :: behind !! stands behind each word
    character(len=:), allocatable :: text            !! for a message
    integer :: i

    text = ''
    do i = 1, size(words)
      if (i > 1 .and. i < size(words)) text = text // ', '
      if (i > 1 .and. i == size(words)) text = text // ' or '
      if (present(before)) text = text // before
      text = text // trim(words(i))
      if (present(behind)) text = text // behind
    end do
  end function any_of

  !> `'off', 'on' or 'auto'`.
  pure function one_of(words) result(text)
    character(len=*), intent(in) :: words(:)  !! at least one
    character(len=:), allocatable :: text     !! for a message

    text = any_of(words, before='''', behind='''')
  end function one_of

end module asperity_word_hint
